"""Lays out the C and C++ library as other build systems expect it: python3 install.py LIBRARIES PREFIX VERSION

include/fabric_kernel.h, fabric_kernel.hpp
lib/libfabric_kernel.a
lib/libfabric_kernel.so -> libfabric_kernel.so.1
lib/pkgconfig/fabric_kernel.pc
lib/cmake/fabric_kernel/fabric_kernel-config.cmake, fabric_kernel-config-version.cmake
share/licenses/fabric_kernel/
"""

import pathlib
import re
import shutil
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]


def copy(source, to):
    """Copies a file. What is there is removed first, not written over: a program that runs with the old library keeps it."""
    to.parent.mkdir(parents=True, exist_ok=True)
    to.unlink(missing_ok=True)
    shutil.copyfile(source, to)
    shutil.copymode(source, to)


def main(built, prefix, version):
    library = prefix / "lib"
    shared = built / "libfabric_kernel.so"
    listed = subprocess.run(["readelf", "-d", shared], check=True, capture_output=True, text=True).stdout
    soname = re.search(r"\(SONAME\).*\[(.*)\]", listed)[1]
    for name in ("fabric_kernel.h", "fabric_kernel.hpp"):
        copy(TOP / "include" / name, prefix / "include" / name)
    copy(built / "libfabric_kernel.a", library / "libfabric_kernel.a")
    copy(shared, library / soname)
    link = library / "libfabric_kernel.so"
    link.unlink(missing_ok=True)
    link.symlink_to(soname)

    major, minor, _ = version.split(".", 2)
    words = {"@VERSION@": version, "@MAJOR@": major, "@MINOR@": minor, "@SONAME@": soname}
    for folder, name in (
        ("pkgconfig", "fabric_kernel.pc"),
        ("cmake/fabric_kernel", "fabric_kernel-config.cmake"),
        ("cmake/fabric_kernel", "fabric_kernel-config-version.cmake"),
    ):
        text = (TOP / "capi/install" / f"{name}.in").read_text()
        (library / folder).mkdir(parents=True, exist_ok=True)
        (library / folder / name).write_text(re.sub("@[A-Z]+@", lambda word: words[word[0]], text))
    licences = prefix / "share/licenses/fabric_kernel"
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        copy(TOP / name, licences / name)
    # Licences of the crates that are linked.
    copy(TOP / "modelDescription/documentation/licenses/license.txt", licences / "crates.txt")
    print(f"  fabric_kernel {version} ({soname}) installed in {prefix}")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3])
