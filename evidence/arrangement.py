"""Arrangement of plies that have a thickness: separate plies over bonded ones, and every other one turned.

Method and limits: those of plies.py, with plies of the assumed thickness that lie on each other without air between them.
"""

from . import plies


def answer(study):
    rows = {part.split(",")[0]: plies.rows_of(study, part) for part in plies.THICK}
    text = f"{plies.verdicts(rows)}\n{plies.table([row for own in rows.values() for row in own])}"
    study.table("arrangement", "Arrangement of plies that have a thickness", text)
