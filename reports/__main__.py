"""`python3 -m reports STUDY [FOLDER] [--docs docs]`."""

import argparse
import importlib
import pathlib
import sys

STUDIES = {
    "paper": ("target/study/paper", "claims with verdicts, figures, report.html; with --docs tables/paper_*.md"),
    "stability": ("target/study/stability", "the map; with --docs tables/stability.md and the map's picture"),
    "strips": ("target/study/strips", "pulls strips, for which the package of ./python must be installed; with --docs tables/strips.md and its picture"),
    "edges": ("target/study/edges", "from which velocity on bars break at once; needs the package, too; with --docs tables/edges.md"),
    "bench": ("target/study/bench", "goals and the plot; with --docs tables/performance.md and the plot"),
    "run": (None, "velocity, force, energies and the sheet of one run"),
}


def main():
    parser = argparse.ArgumentParser(prog="python3 -m reports", description=__doc__)
    studies = parser.add_subparsers(dest="study", required=True, metavar="STUDY")
    for name, (folder, words) in STUDIES.items():
        study = studies.add_parser(name, help=words)
        what = "what fabric-study has written" + (" [default: %(default)s]" if folder else "")
        study.add_argument("folder", type=pathlib.Path, nargs="?" if folder else None, default=folder, help=what)
        if folder:
            study.add_argument("--docs", type=pathlib.Path, metavar="DIR", help="also write the generated tables into this folder of documents")
    arguments = parser.parse_args()
    try:
        report = importlib.import_module("reports." + arguments.study.replace("-", "_"))
    except ModuleNotFoundError as error:
        sys.exit(f"error: {error}: python3 -m pip install -r requirements.txt installs what the reports need, and strips and edges need ./python, too")
    try:
        report.report(pathlib.Path(arguments.folder), getattr(arguments, "docs", None))
    except FileNotFoundError as error:
        sys.exit(f"error: {error.filename}: not there; `fabric-study {arguments.study}` writes it")


main()
