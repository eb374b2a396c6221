"""`python -m evidence`: the questions; `python -m evidence NAME`: the answer to one; `python -m evidence --quick`: to all of
them."""

import argparse
import importlib
import logging
import pathlib
import sys
import time

# A question's name, which is that of its file; what it asks; how long its answer took, and with --quick: on two cores beside
# other programs, empty where that was not measured.
QUESTIONS = {
    "paper": ("every result of the paper, and the open question", "", "3 min"),
    "clamps": ("the paper's question with attachments that slip", "16 min", "2 min"),
    "coverage": ("how often the intervals of a ballistic limit hold the truth", "66 min", "1 min"),
    "own_tests": ("how often the interval of own firing tests holds another shield", "1 min", "10 s"),
    "strips": ("strips of Kevlar 49 fabric pulled in the network", "3 min", "10 s"),
    "edges": ("from which velocity on bars break at once under a flat face and a sphere", "5 s", "5 s"),
    "stability": ("the energy that the time step creates, over step and impact velocity", "15 s", "5 s"),
    "oneply": ("one ply: the network beside resolved yarns, and when a window opens", "", "15 s"),
    "bench": ("the goals beside what `cargo xtask bench` has measured", "", ""),
    "friction": ("what friction on the projectile does to energy and ballistic limit", "", "3 min"),
    "plies": ("many thin plies against a thick one, gaps, turned plies", "2 min", "20 s"),
    "arrangement": ("separate and turned plies that have a thickness", "2 min", "20 s"),
    "smooth": ("error and order of both integrators in a smooth motion", "5 s", "5 s"),
    "accuracy": ("error over run time: presets, six whole impacts, how often what was asked for is kept", "", ""),
    "number": ("how far rounding parts runs, whole and quarter, and how many a mean needs", "3 min", "40 s"),
    "viscosity": ("what viscosity leaves of the overshoot of a strip, and does to whole impacts", "3 min", "20 s"),
    "rings": ("wraps: flat cloth, pre-tension, turns, angle of impact, spacing", "2 min", "10 s"),
    "grading": ("graded networks against the whole fabric", "", "1 min"),
    "through": ("how often the outcome through is wrong near the ballistic limit, and in oblique hits", "66 min", "4 min"),
    "coupling": ("schemes for a projectile that its host moves", "1 min", "20 s"),
    "validation": ("the six questions below together, with the table of their verdicts", "", "30 s"),
    "yarn": ("one yarn hit across: strain, waves, critical velocity", "10 s", "5 s"),
    "strength": ("Kevlar 49 yarn at six gauge lengths", "10 s", "5 s"),
    "rate": ("Kevlar 49 fabric at three rates of strain", "5 s", "5 s"),
    "cone": ("the pyramid of a sheet hit at a point", "10 s", "5 s"),
    "spacing": ("convergence of energy and ballistic limit in the spacing", "40 s", "5 s"),
    "mesh": ("convergence in the network of bodies with edges, with and without thickness", "30 min", "20 s"),
    "packs": ("ballistic limit of packs as measured, in three networks", "", "10 s"),
}


# What is read in another folder, and must be there.
READS = {"bench": "bench.json"}


def listed():
    lines = [f"  {name:<11} {what:<84} {full:>6} {quick:>7}" for name, (what, full, quick) in QUESTIONS.items()]
    return "\n".join([f"  {'question':<11} {'':<84} {'takes':>6} {'--quick':>7}", *lines])


def main():
    parser = argparse.ArgumentParser(
        prog="python -m evidence",
        description="The evidence of the documents. Times were measured on two cores beside other programs.",
        epilog=listed(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("question", nargs="?", choices=list(QUESTIONS), metavar="QUESTION", help="the one to answer")
    parser.add_argument("folder", nargs="?", type=pathlib.Path, help="what bench reads [default: target/fabric/QUESTION]")
    effort = parser.add_mutually_exclusive_group()
    effort.add_argument(
        "--quick",
        action="store_const",
        const="quick",
        dest="effort",
        help="fewer points and runs; without a question all are answered",
    )
    effort.add_argument(
        "--smoke",
        action="store_const",
        const="smoke",
        dest="effort",
        help="the least that runs every line: a check, not a result",
    )
    parser.add_argument(
        "--out", type=pathlib.Path, default=pathlib.Path("target/evidence"), help="folder of the numbers [default: %(default)s]"
    )
    parser.add_argument(
        "--docs", type=pathlib.Path, metavar="DIR", help="also write pages and pictures into this folder of documents"
    )
    parser.add_argument(
        "--on", metavar="ADDRESS", help="a Dask scheduler whose workers have this clone and the same build of the package"
    )
    parser.add_argument("--anew", action="store_true", help="forget the runs that are kept")
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    if not given.question and not given.effort:
        print(listed())
        return
    try:
        from . import comparison, study, validation
    except ModuleNotFoundError as error:
        sys.exit(f"error: {error}: `python -m pip install ./python[all]` installs what is needed")
    sound = True
    parts = validation.PARTS  # They are answered together.
    for name in [given.question] if given.question else [name for name in QUESTIONS if name not in parts]:
        start = time.monotonic()
        asked = study.Study(name, given.effort or study.FULL, given.out, given.docs, given.on, given.folder)
        if name in READS and not (asked.source / READS[name]).exists():
            print(f"{name}: there is no {asked.source / READS[name]}; `fabric {name}` writes it")
            sound &= not given.question
            continue
        if given.anew:
            asked.kept.unlink(missing_ok=True)
        question = importlib.import_module(f"evidence.{name}")
        # False: something is not as it must be.
        try:
            sound &= (question.answer(asked) if hasattr(question, "answer") else comparison.alone(asked, question)) is not False
        except KeyboardInterrupt:
            sys.exit("stopped: the same command goes on from here")
        print(f"{name}: {time.monotonic() - start:.0f} s; written: {asked.folder}", flush=True)
    sys.exit(0 if sound else 1)


if __name__ == "__main__":
    main()
