"""`fabric fmu SCENE`: FMUs that start with a scene, from those of a release. No compiler is needed.

Each library in the archive has a reserved block of data (fmu/src/starts.rs). The scene's numbers go there; names, start values,
token and page follow.
"""

import hashlib
import html
import io
import itertools
import math
import re
import struct
import sys
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy

from . import about as scenes
from ._kernel import PRESETS, VERSION, Scene, Simulation, parameters
from .files import apart, written

MODEL, DESCRIPTION, PAGE = "FabricShield", "modelDescription.xml", "documentation/index.html"
MARK, EMPTY = b"FabricSceneBlock", b"no scene"
STARTS = {
    f"projectile.{name}": f"projectile.start.{name}" for name in ("position", "velocity", "orientation", "angular_velocity")
}
KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if int long register return short "
    "signed sizeof static struct switch typedef union unsigned void volatile while"
).split()
WORD = 2**64 - 1


class Archive:
    """An FMU of this project: its entries, its model description, and the build of its libraries."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with zipfile.ZipFile(path) as packed:
                self.entries = {name: packed.read(name) for name in packed.namelist() if not name.endswith("/")}
        except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, LookupError, RuntimeError, ValueError) as error:
            raise ValueError(f"{path}: damaged, or no FMU: {error}") from None
        self.binaries = [name for name in self.entries if name.startswith("binaries/")]
        for name in (DESCRIPTION, PAGE, *([] if self.binaries else ["binaries/"])):
            if name not in self.entries:
                raise ValueError(f"{path}: no FMU of fabric: it has no {name}")
        name = PAGE
        try:
            self.page, name = self.entries[PAGE].decode(), DESCRIPTION
            root: Any = ElementTree.fromstring(self.entries[DESCRIPTION])
        except (ElementTree.ParseError, ValueError) as error:
            raise ValueError(f"{path}: {name} is damaged: {error}") from None
        self.key = {"2.0": "guid", "3.0": "instantiationToken"}.get(root.get("fmiVersion"), "")
        token = re.fullmatch(r"\{FabricShield-([0-9a-f]{13})\}", root.get(self.key, ""))
        if token is None:
            raise ValueError(f"{path}: no FMU of fabric")
        if root.get("version") != VERSION:
            raise ValueError(f"{path}: an FMU of version {root.get('version')}; this is version {VERSION}")
        self.root, self.version, self.name, self.token = (
            root,
            int(root.get("fmiVersion")[0]),
            root.get("modelName"),
            int(token[1], 16),
        )

    def block(self, binary: str, count: int) -> tuple[int, int]:
        """Where the block of a library begins after its layout, and the build of the library. `count`: words of a scene."""
        data = self.entries[binary]
        if data.count(MARK) != 1:
            raise ValueError(f"{self.path}: {binary} takes no scene")
        at = data.index(MARK) + len(MARK) + 8
        if len(data) < at + 8 * (3 + count):
            raise ValueError(f"{self.path}: {binary} is cut off")
        if struct.unpack_from("<II", data, at - 8) != (count, 1):
            raise ValueError(f"{self.path}: {binary} is of another version; this is version {VERSION}")
        return at, self.token if data[at : at + 8] == EMPTY else struct.unpack_from("<Q", data, at)[0]


def checksum(words: Sequence[int]) -> int:
    """The kernel's hash of words."""
    value = 0xCBF29CE484222325
    for word in words:
        value = (value ^ word) * 0x100000001B3 & WORD
        value ^= value >> 29
    return value


def variables(words: Sequence[int], version: int) -> Iterator[tuple[str, list[int]]]:
    """Names of the scene's variables with their words: elements in FMI 2.0, arrays in FMI 3.0."""
    rest = iter(words)
    for row in parameters():
        name = STARTS.get(row["name"], row["name"])
        indices = list(itertools.product(*(range(1, size + 1) for size in row["shape"])))
        own = list(itertools.islice(rest, len(indices)))
        if version == 3:
            yield name, own
        else:
            yield from ((name + (f"[{','.join(map(str, index))}]" if index else ""), [word]) for index, word in zip(indices, own))


def shown(kind: str, word: int) -> str:
    """The text of a start value, as Rust writes numbers."""
    if kind in ("Real", "Float64"):
        return re.sub(r"e([+-])0*", lambda part: "e" + part[1].strip("+"), repr(struct.unpack("<d", struct.pack("<Q", word))[0]))
    return str(bool(word)).lower() if kind == "Boolean" else str(word)


def typed(element: Any) -> Any:
    """What has the type of a variable or of a type: in FMI 2.0 its only child."""
    return element[0] if element.tag in ("ScalarVariable", "SimpleType") else element


def started(root: Any, words: dict[str, list[int]]) -> dict[str, list[str]]:
    """Writes these start values into a model description, and returns their texts by the name of the variable."""
    least = {one.get("name"): typed(one).get("min", "-inf") for one in root.find("TypeDefinitions")}
    texts: dict[str, list[str]] = {}
    for variable in root.find("ModelVariables"):
        if (name := variable.get("name")) not in words:
            continue
        if name != next(iter(words)):  # The library takes the words in the order of its variables.
            raise ValueError(f"{name}: the FMU has its parameters in another order: it is of another version")
        one = typed(variable)
        low, high = float(one.get("min") or least.get(one.get("declaredType"), "-inf")), float(one.get("max", "inf"))
        values = [shown(one.tag, word) for word in words.pop(name)]
        for value in values:
            if one.tag != "Boolean" and not (math.isfinite(float(value)) and low <= float(value) <= high):
                raise ValueError(f"{name}: {value} cannot be a start value of an FMU")
        texts.setdefault(name.partition("[")[0], []).extend(values)
        one.set("start", " ".join(values))
    if words:
        raise ValueError(f"no variable {next(iter(words))}: the FMU is of another version")
    return texts


def picture(scene: Scene, simulation: Simulation) -> str:
    """Sheet and projectile from the front and from the side, and what they are."""
    from . import sheets  # Which needs matplotlib.

    nodes = simulation.positions()
    rows, columns, plies = nodes.shape[0], nodes.shape[1], scene["stack.plies"]
    some = lambda count: [*range(0, count, max(1, count // 60)), count - 1]
    across, along = some(columns) + [0] * scene["sheet.closed"], some(rows // plies)
    lines = [
        nodes[ply * rows // plies + row, across] for ply in {0, plies - 1} for row in (0, rows // plies // 2, rows // plies - 1)
    ]
    lines += [nodes[along, column] for column in (0, columns // 2, columns - 1)]
    body = simulation.projectile()
    turned = [
        numpy.array(body["position"]) + sheets.turned(numpy.array(body["orientation"]), line) for line in sheets.outline(scene)
    ]
    low, high = (edge(numpy.concatenate([*lines, *turned]), axis=0) for edge in (numpy.min, numpy.max))
    scale = 340.0 / max(high - low)
    views = []
    for right, up, title in ((0, 1, "x, y"), (2, 0, "z, x")):
        at = lambda point: f"{scale * (point[right] - low[right]) + 0.0:.1f} {scale * (high[up] - point[up]) + 0.0:.1f}"
        path = lambda parts: "".join("M" + "L".join(map(at, part)) for part in parts)
        views.append(
            f'<g transform="translate({20 + 190 * right} 24)" fill="none"><text y="-8" fill="#4b5563">{title}</text><path '
            f'd="{path(lines)}" stroke="#1f5a94"/>'
            f'<path d="{path(turned)}" stroke="#b45309"/></g>\n'
        )
    height = 34 + math.ceil(scale * max((high - low)[:2]))
    about = html.escape(" ".join(scenes.described(scene, scene.fabrics[0] or "")))
    return (
        f'<figure id="scene">\n<svg viewBox="0 0 760 {height}" width="760" font-family="system-ui, sans-serif" font-size="13" '
        f'role="img" '
        f'aria-label="The scene of the start values">\n{"".join(views)}</svg>\n<figcaption>The start values. '
        f"{about}</figcaption>\n</figure>\n"
    )


def filled(archive: Path, scene: Scene, name: str) -> tuple[int, bytes]:
    """FMI version and bytes of an FMU with the start values of a scene. The same scene, name and archive give the same bytes.

    Raises ValueError for a name that is no identifier, a scene that is refused, and an archive that is no FMU of this version.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in (MODEL, *KEYWORDS):
        raise ValueError(f"--name {name}: letters, digits and _, a letter first; not {MODEL}, no word of C")
    fmu, words, simulation = Archive(archive), scene.words(), Simulation(scene)
    time_step = shown("Real", struct.unpack("<Q", struct.pack("<d", simulation.step_limits()["dt"]))[0])
    starts = started(fmu.root, dict(variables(words, fmu.version)))
    blocks = {binary: fmu.block(binary, len(words)) for binary in fmu.binaries}
    if len(builds := {build for _, build in blocks.values()}) != 1:
        raise ValueError(f"{archive}: its libraries are of different builds")
    build = builds.pop()
    content = struct.pack(f"<Q{len(words)}Q", build, *words)
    token = int.from_bytes(hashlib.sha256(content + name.encode()).digest()[:8], "little") >> 12
    block = struct.pack(f"<QQQ{len(words)}Q", build, token, checksum([build, token, *words]), *words)
    fmu.root.attrib |= {"modelName": name, fmu.key: f"{{FabricShield-{token:013x}}}"}
    told = {"modelIdentifier": name, "fixedInternalStepSize": time_step}
    fmu.root.find("CoSimulation").attrib |= told if fmu.version == 3 else {"modelIdentifier": name}
    text = ElementTree.tostring(fmu.root, encoding="UTF-8", xml_declaration=True)
    cell = lambda values: values[0] if len(set(values)) == 1 else " ".join(values)
    row = lambda found: found[1] + (cell(starts[found[2]]) if found[2] in starts else found[3])
    page = re.sub(r"(<tr><td><code>([^<]+)</code>[^<]*</td><td>)([^<]*)", row, fmu.page)
    for place in ("<title>{}</title>", "<h1>{}</h1>", '"{}-fmi'):
        page = page.replace(place.format(fmu.name), place.format(name))
    page = re.sub(r"with the start values \S+ s\.", f"with the start values {time_step} s.", page)
    page = re.sub(r"<code>documentation/parameters</code>.*\n", "", page)
    page = re.sub(r'<figure id="scene">.*?</figure>\n', "", page, flags=re.DOTALL)
    page = page.replace("<figure>", picture(scene, simulation) + "<figure>", 1)
    entries = {DESCRIPTION: text, PAGE: page.encode()}
    for path, data in fmu.entries.items():
        if path in blocks:
            at = blocks[path][0]
            folder, _, file = path.rpartition("/")
            entries[f"{folder}/{name}.{file.rpartition('.')[2]}"] = data[:at] + block + data[at + len(block) :]
        elif not path.startswith("documentation/parameters/"):
            entries.setdefault(path, data)
    return fmu.version, packed(entries)


def packed(entries: dict[str, bytes]) -> bytes:
    """An archive whose bytes depend on the entries alone: not compressed, since zlib's versions compress differently."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, data in sorted(entries.items()):
            entry = zipfile.ZipInfo(name)
            entry.create_system, entry.external_attr = 3, (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            archive.writestr(entry, data)
    return out.getvalue()


def system(name: str, fmu: bytes) -> bytes:
    """A package of SSP 1.0 with an FMU of FMI 2.0, its inputs and outputs as connectors, and its parameters as a parameter
    set."""
    with zipfile.ZipFile(io.BytesIO(fmu)) as archive:
        root: Any = ElementTree.fromstring(archive.read(DESCRIPTION))
    found = [
        (one.get("name"), one.get("causality"), one[0].tag, one[0].get("start")) for one in root.iterfind(".//*[@causality]")
    ]
    space = lambda *names: "".join(
        f' xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{long}"' for short, long in names
    )
    ports = "".join(
        f'<ssd:Connector name="{port}" kind="{kind}"><ssc:{of}/></ssd:Connector>\n'
        for port, kind, of, _ in found
        if kind != "parameter"
    )
    values = "".join(
        f'<ssv:Parameter name="{port}"><ssv:{of} value="{value}"/></ssv:Parameter>\n'
        for port, kind, of, value in found
        if kind == "parameter"
    )
    start = '<?xml version="1.0" encoding="UTF-8"?>\n'
    ssd = (
        f'{start}<ssd:SystemStructureDescription version="1.0" '
        f'name="{name}"{space(("ssd", "Description"), ("ssc", "Common"))}>\n<ssd:System name="{name}">\n'
        f'<ssd:Elements>\n<ssd:Component name="shield" type="application/x-fmu-sharedlibrary" source="resources/{name}.fmu">\n'
        f"<ssd:Connectors>\n{ports}"
        f'</ssd:Connectors>\n<ssd:ParameterBindings>\n<ssd:ParameterBinding source="resources/{name}.ssv"/>\n'
        "</ssd:ParameterBindings>\n</ssd:Component>\n</ssd:Elements>\n</ssd:System>\n</ssd:SystemStructureDescription>\n"
    )
    ssv = (
        f'{start}<ssv:ParameterSet version="1.0" name="{name}"{space(("ssv", "ParameterValues"))}>\n<ssv:Parameters>\n'
        f"{values}</ssv:Parameters>\n</ssv:ParameterSet>\n"
    )
    return packed({"SystemStructure.ssd": ssd.encode(), f"resources/{name}.ssv": ssv.encode(), f"resources/{name}.fmu": fmu})


def options() -> scenes.Parser:
    ends = "Exit status: 0; 2 for what is refused, and then nothing is written."
    parser = scenes.options("fmu", "FMUs that start with a scene, from those of a release.", ends)
    add = parser.add_argument
    add("scene", help=f"a scene file, or a preset: {', '.join(PRESETS)}")
    add("--version", type=int, choices=(2, 3), help="of FMI; default: each that there is")
    add(
        "--from",
        dest="source",
        type=Path,
        default=Path(),
        metavar="ARCHIVE",
        help=f"an FMU of a release, or the folder of {MODEL}-fmi2.fmu and -fmi3.fmu; default: this folder",
    )
    add(
        "--ssp",
        action="store_true",
        help="also NAME.ssp, a package of SSP 1.0 with the FMU of FMI 2.0 and the scene as a parameter set",
    )
    add("--name", help="of the model; default: that of the scene's file, as DiscSector for disc_sector.toml")
    add(
        "--out", type=Path, default=Path(), metavar="FOLDER", help="folder for NAME-fmi2.fmu and NAME-fmi3.fmu; default: this one"
    )
    return parser


def main(arguments: Sequence[str] | None = None) -> None:
    """The command `fabric fmu`."""
    parser = options()
    given = parser.parse_args(arguments)
    with scenes.ending(parser, given):
        scene = Scene.read(given.scene)
        stem = Path(given.scene).name.removesuffix(".toml")
        name = given.name or "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", stem))
        archives = [given.source]
        if given.source.is_dir():
            archives = [given.source / f"{MODEL}-fmi{version}.fmu" for version in ([given.version] if given.version else (2, 3))]
            if not given.version and any(path.exists() for path in archives):
                archives = [path for path in archives if path.exists()]
        made = [filled(path, scene, name) for path in archives]
        for version, _ in made:
            if given.version not in (None, version):
                raise ValueError(f"{given.source}: an FMU of FMI {version}.0; --version is {given.version}")
        files = {f"{name}-fmi{version}.fmu": data for version, data in made}
        if given.ssp and f"{name}-fmi2.fmu" not in files:
            raise ValueError(f"--ssp: needs an FMU of FMI 2.0: {given.source}")
        if given.ssp:
            files[f"{name}.ssp"] = system(name, files[f"{name}-fmi2.fmu"])
        apart([given.scene, *archives], [given.out / file for file in files])
        given.answer = {str(given.out / file): len(data) for file, data in files.items()}
        with scenes.folder(given.out, "numpy"):
            for file, data in files.items():
                written(given.out / file, data)
                print(f"{given.out / file}: {len(data)} bytes", flush=True)
        if any(f"/{name}.dylib".encode() in data for _, data in made):
            print("warning: the libraries for macOS need a signature: codesign --force --sign - FILE, on a Mac", file=sys.stderr)


if __name__ == "__main__":
    main()
