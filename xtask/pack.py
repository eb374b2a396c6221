"""Packs files: python3 pack.py ARCHIVE NAME=FILE ..."""

import pathlib
import sys
import zipfile

with zipfile.ZipFile(sys.argv[1], "w") as archive:
    for name, path in sorted(entry.split("=", 1) for entry in sys.argv[2:]):
        entry = zipfile.ZipInfo(name)  # of 1980
        entry.create_system = 3
        entry.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
        archive.writestr(entry, pathlib.Path(path).read_bytes(), zipfile.ZIP_DEFLATED, 9)
