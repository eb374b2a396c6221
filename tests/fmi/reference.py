"""Reference results of the default run, in the manner of the FMI cross-check. Both FMUs give them to the last bit.

python tests/fmi/reference.py            # writes examples/reference; `cargo xtask fmu` must have packed the FMUs
python tests/fmi/reference.py --check    # runs both FMUs to the end and compares
"""

import csv
import pathlib
import sys

from host import OUTPUTS, Host, opened

FOLDER = pathlib.Path(__file__).parents[2] / "examples" / "reference"
STEP, INTERVAL, STOP = 1e-6, 1e-5, 1e-3  # s
PER_ROW = round(INTERVAL / STEP)
INPUTS = (
    "projectile.position projectile.velocity projectile.orientation projectile.angular_velocity projectile.acceleration "
    "external.force external.torque"
).split()


def columns(names):
    """The scalar variables, as FMI 2.0 names them."""
    variables = [variable.name for variable in opened(2)[0].modelVariables]
    return [column for name in names for column in variables if column == name or column.startswith(name + "[")]


def flat(values):
    return [x for value in values for x in (value if isinstance(value, list) else [value])]


def inputs():
    """Two rows: the start values of all inputs, held."""
    host = Host(2, {})
    row = [repr(x) for x in flat([host.get(name) for name in INPUTS])]
    return [["time", *columns(INPUTS)], ["0.0", *row], [repr(STOP), *row]]


def read(name):
    with open(FOLDER / name, newline="", encoding="ascii") as file:
        return list(csv.reader(file))


def rows(version, count, values=None):
    """The first rows of the run: time and all outputs as texts that read back exactly."""
    host, result = Host(version, values or {}, stop=STOP), []
    for row in range(count):
        host.run((row - 1) * PER_ROW if row else 0, row * PER_ROW, STEP)
        result.append([repr(round(row * INTERVAL, 9)), *(repr(x) for x in flat(host.outputs().values()))])
    return result


def options():
    named = [("StartTime", 0.0), ("StopTime", STOP), ("StepSize", STEP), ("RelTol", 0.0), ("OutputIntervalLength", INTERVAL)]
    return "".join(f"{name}, {value!r}\n" for name, value in named)


def write():
    FOLDER.mkdir(parents=True, exist_ok=True)
    results = [["time", *columns(OUTPUTS)], *rows(2, round(STOP / INTERVAL) + 1)]
    for name, table in (("FabricShield_ref.csv", results), ("FabricShield_in.csv", inputs())):
        with open(FOLDER / name, "w", newline="", encoding="ascii") as file:
            csv.writer(file, lineterminator="\n").writerows(table)
    (FOLDER / "FabricShield_ref.opt").write_text(options(), encoding="ascii")
    print(f"wrote {FOLDER}")


def start_values():
    """What the input file says at the start, by variable."""
    header, first, _ = read("FabricShield_in.csv")
    values = {}
    for column, value in zip(header[1:], first[1:]):
        values.setdefault(column.split("[")[0], []).append(float(value))
    return values


def check():
    """A message if a whole run of either FMU is not what the files say."""
    header, *expected = read("FabricShield_ref.csv")
    for version, values in ((2, {}), (3, start_values())):
        if rows(version, len(expected), values) != expected:
            return f"the run of FMI {version}.0 is not what examples/reference says: run tests/fmi/reference.py"
    print(f"both FMUs give all {len(expected)} rows of examples/reference, {len(header)} columns, to the last bit")
    return None


if __name__ == "__main__":
    sys.exit(check() if sys.argv[1:] == ["--check"] else write())
