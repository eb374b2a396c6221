"""The model against closed forms and published measurements, with the data of yarns and fabrics as its only input: all questions
of it together.

The measurements are in data/measured/*.toml and the fabrics in data/fabrics/*.toml.
"""

import importlib

from . import comparison
from .study import Study

PARTS = ("yarn", "strength", "rate", "cone", "spacing", "packs")


def answer(study):
    comparisons, text, sound = [], "", True
    for name in PARTS:
        part = importlib.import_module(f"evidence.{name}")
        found, its_text, good = part.compared(Study(name, study.effort, study.out, study.docs, study.on))
        comparisons, text, sound = comparisons + found, f"{text}\n{its_text}", sound and good
    markdown, printed = comparison.verdicts(comparisons)
    print(printed)
    study.table("validation", "The model against closed forms and measurements", comparison.RULE + markdown + text)
    return sound
