"""The benchmark of this clone against that of another revision, in turn, so that the machine's load meets both alike.

    python3 evidence/bench/compare.py REVISION [--only CASE] [--instructions SET] [--pairs 11]

Method: git checks the revision out into target/compare, cargo builds it there, and its program is kept for the next time. Both
then measure the same cases in turn, as programs of their own, each going first in every other pair. What is told is the ratio of
their medians within a pair: its median over the pairs, and half the range of the middle half of them as noise. Ends with 1 if the
bits differ.
Limits: cases that both revisions have under the same name; a load that changes within a pair, some seconds, is not cancelled.
"""

import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

TOP = pathlib.Path(__file__).parents[2]
FOLDER = TOP / "target" / "compare"


def build(checkout):
    """The program of a checkout, built into a folder of its own."""
    name = "fabric" if (checkout / "runner").exists() else "fabric-bench"
    target = TOP / "target" if checkout == TOP else FOLDER / "build"
    subprocess.run(
        ["cargo", "build", "--quiet", "--release", "--package", name, "--target-dir", target], cwd=checkout, check=True
    )
    return target / "release" / name


def of_revision(revision):
    git = lambda *words: subprocess.run(["git", *words], cwd=TOP, check=True, capture_output=True, text=True).stdout.strip()
    commit = git("rev-parse", "--verify", "--short=12", revision + "^{commit}")
    kept, checkout = FOLDER / "programs" / commit, FOLDER / commit
    if not kept.exists():
        git("worktree", "add", "--detach", "--force", checkout, commit)
        try:
            program = build(checkout)
            kept.mkdir(parents=True)
            shutil.copy(program, kept)
        finally:
            git("worktree", "remove", "--force", checkout)
    return next(kept.iterdir())


def measured(program, case, instructions):
    """Median and digest of every way in which a case is stepped."""
    out = FOLDER / "pair"
    # Until version 0.1.0 the benchmark was a command of another program.
    words = ["bench"] if program.name == "fabric" else []
    subprocess.run(
        [program, *words, "--quick", "--only", case, "--instructions", instructions, "--out", out],
        check=True,
        capture_output=True,
    )
    rows = json.loads((out / "bench.json").read_text())["rows"]
    return {
        (row["case"], row["size"], row["instruction_set"], row["threads"]): (row["median"], row["digest"])
        for row in rows
        if row["median"]
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("revision")
    parser.add_argument("--only", nargs="*", default=["sweep 105", "run 105", "sweep 350", "run 350"])
    parser.add_argument("--instructions", default="")
    parser.add_argument("--pairs", type=int, default=11)
    given = parser.parse_args()
    programs, alike = [of_revision(given.revision), build(TOP)], True
    for case in given.only:
        pairs = []
        for pair in range(given.pairs):
            found = {which: measured(programs[which], case, given.instructions) for which in (pair % 2, 1 - pair % 2)}
            pairs.append((found[0], found[1]))
        for way in [way for way in pairs[0][1] if way in pairs[0][0]]:
            ratios = sorted(now[way][0] / before[way][0] for before, now in pairs)
            middle, quarter = statistics.median(ratios), len(ratios) // 4
            noise = 50 * (ratios[-1 - quarter] - ratios[quarter]) / middle
            bits = "same" if all(now[way][1] == before[way][1] for before, now in pairs) else "DIFFERENT"
            alike &= bits == "same"
            print(*way, f"threads: {middle:.3f} of the time of {given.revision}, noise {noise:.1f} %, {bits} bits", flush=True)
    sys.exit(0 if alike else 1)


if __name__ == "__main__":
    main()
