"""Notes for a reader that a program can read, too, and warnings made of them."""

import warnings
from collections.abc import Iterable, Mapping


class ModelWarning(RuntimeWarning):
    """Warning that a result is in doubt.

    Parameters
    ----------
    text : str
        Sentence on what is in doubt and what to do.
    kind : str
        Name of what is in doubt, as "energy_residual"; notes of reports have it, too.
    numbers : mapping, optional
        Numbers that it is decided by.
    """

    def __init__(self, text: str, kind: str, numbers: Mapping[str, float] | None = None) -> None:
        super().__init__(text)
        self.kind, self.numbers = kind, dict(numbers or {})


class Note(str):
    """Sentence whose `kind` names what it says; `numbers` has what it is decided by. As a text it is the sentence."""

    kind: str
    numbers: dict[str, float]

    def __new__(cls, text: str, kind: str, numbers: Mapping[str, float]) -> "Note":
        note = super().__new__(cls, text)
        note.kind, note.numbers = kind, dict(numbers)
        return note

    @property
    def text(self) -> str:
        return str(self)

    def __getnewargs__(self) -> tuple[str, str, dict[str, float]]:  # type: ignore[override]
        return str(self), self.kind, self.numbers


def warn(notes: Iterable[Note]) -> None:
    """Warns of notes where the caller of a public function is."""
    for note in notes:
        warnings.warn(ModelWarning(note, note.kind, note.numbers), stacklevel=3)
