"""The archives: accepted by the validator, complete, and one library behind both."""

import pathlib
import re
import subprocess
import zipfile

import fmpy
from fmpy.validation import validate_fmu
from host import ARCHIVES, Host, library, opened
from lxml import etree


def test_the_validator_finds_nothing():
    for archive in ARCHIVES.values():
        assert validate_fmu(str(archive)) == []
    print("\nfigure 25: FMPy's validator: 0 errors", flush=True)


def test_entries():
    for archive in ARCHIVES.values():
        with zipfile.ZipFile(archive) as packed:
            entries = packed.infolist()
        names = [entry.filename for entry in entries]
        assert names == sorted(names)
        assert all(entry.date_time == (1980, 1, 1, 0, 0, 0) for entry in entries)
        for wanted in ["modelDescription.xml", "documentation/index.html", "documentation/licenses/license.txt"]:
            assert wanted in names
        assert any(name.endswith("/FabricShield.so") for name in names)


def test_the_terminals_follow_the_schema_and_name_variables():
    schema = etree.XMLSchema(etree.parse(str(pathlib.Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd")))
    with zipfile.ZipFile(ARCHIVES[3]) as packed:
        tree = etree.fromstring(packed.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema.assertValid(tree)
    names = {variable.name for variable in opened(3)[0].modelVariables}
    for member in tree.iter("TerminalMemberVariable"):
        assert member.get("variableName") in names


def test_the_library_exports_the_standard_functions():
    """What it may need of its host `cargo xtask fmu` checks."""
    headers = pathlib.Path(fmpy.__file__).parent / "c-code"
    text = "".join((headers / f"fmi{v}FunctionTypes.h").read_text() for v in (2, 3))
    wanted = set(re.findall(r"\b(fmi[23]\w+)TYPE\b", text))
    # FMI 2.0 for model exchange is not exported.
    wanted -= set(
        (
            "fmi2EnterEventMode fmi2NewDiscreteStates fmi2EnterContinuousTimeMode fmi2CompletedIntegratorStep fmi2SetTime "
            "fmi2SetContinuousStates fmi2GetDerivatives fmi2GetEventIndicators fmi2GetContinuousStates "
            "fmi2GetNominalsOfContinuousStates"
        ).split()
    )
    listed = subprocess.run(["nm", "-D", "--defined-only", library(2)], check=True, capture_output=True, text=True)
    assert {line.split()[-1] for line in listed.stdout.splitlines()} == wanted


def test_the_icons_are_pictures():
    for version, name in ((2, "model.png"), (3, "terminalsAndIcons/icon.png")):
        with zipfile.ZipFile(ARCHIVES[version]) as packed:
            assert packed.read(name)[:8] == b"\x89PNG\r\n\x1a\n"


def test_every_variable_answers_and_starts_as_described(version):
    host = Host(version)
    host.begin({})
    for variable in host.variables.values():
        if variable.causality == "independent":
            continue
        value = host.get(variable.name)
        if variable.start is not None and variable.causality != "output":
            given = variable.start if isinstance(variable.start, list) else str(variable.start).split()
            values = value if isinstance(value, list) else [value]
            as_number = {"true": 1, "false": 0}
            wanted = [float(as_number.get(str(x).lower(), x)) for x in given]
            assert [float(x) for x in values] == wanted, variable.name
