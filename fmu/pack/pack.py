"""Packs the FMUs, so that the same files give the same bytes: sorted, with one fixed time and mode.

python3 pack.py shield FOLDER [COMPONENT.wasm] PLATFORM2,PLATFORM3=LIBRARY ...  both FMUs with these libraries
python3 pack.py ARCHIVE NAME=FILE ...                                           any other archive
"""

import pathlib
import sys
import zipfile

TOP = pathlib.Path(__file__).resolve().parents[2]
NAME = "FabricShield"
# The layered standard's manifest in an archive: as the draft calls it, and as the schema of FMI 3.0 does.
MANIFESTS = [f"extra/org.modelica.fmi-ls-wasm/{name}" for name in ("manifest.xml", "fmi-ls-manifest.xml")]


def shield(version, component, libraries):
    """The entries of an FMU: name and file."""
    made = TOP / "modelDescription"
    entries = {name: made / name for name in ("documentation/index.html", "documentation/licenses/license.txt")}
    entries["modelDescription.xml"] = made / f"fmi{version}.xml"
    if version == 2:
        entries["model.png"] = made / "icon.png"
        entries |= {f"documentation/parameters/{one.name}": one for one in (TOP / "examples/parameters").glob("*.ssv")}
    else:
        entries["terminalsAndIcons/icon.png"] = made / "icon.png"
        entries["terminalsAndIcons/terminalsAndIcons.xml"] = made / "terminalsAndIcons.xml"
    if version == 3 and component:
        entries[f"binaries/wasm32-wasip2/{NAME}.wasm"] = pathlib.Path(component)
        entries |= dict.fromkeys(MANIFESTS, made / "fmi-ls-wasm.xml")
    for folders, library in (entry.split("=", 1) for entry in libraries):
        entries[f"binaries/{folders.split(',')[version - 2]}/{NAME}{pathlib.Path(library).suffix}"] = pathlib.Path(library)
    return entries


def pack(archive, entries):
    with zipfile.ZipFile(archive, "w") as packed:
        for name, path in sorted(entries.items()):
            entry = zipfile.ZipInfo(name)  # of 1980
            entry.create_system = 3
            entry.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            packed.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED, 9)


def main(words):
    if words[0] == "shield":
        folder = pathlib.Path(words[1])
        folder.mkdir(parents=True, exist_ok=True)
        component = next((word for word in words[2:] if word.endswith(".wasm")), None)
        libraries = [word for word in words[2:] if word != component]
        for version in (2, 3):
            pack(folder / f"{NAME}-fmi{version}.fmu", shield(version, component, libraries))
    else:
        pack(words[0], {name: pathlib.Path(path) for name, path in (word.split("=", 1) for word in words[1:])})


if __name__ == "__main__":
    main(sys.argv[1:])
