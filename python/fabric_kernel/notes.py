"""Notes for a reader that a program can read, too."""

from collections.abc import Mapping
from typing import Any


class Note(str):
    """A sentence; `code` names what it says, and `numbers` has what it is decided by. As a text it is the sentence."""

    code: str
    numbers: dict[str, float]

    def __new__(cls, text: str, code: str, numbers: Mapping[str, float]) -> "Note":
        note = super().__new__(cls, text)
        note.code, note.numbers = code, dict(numbers)
        return note

    @property
    def text(self) -> str:
        return str(self)

    def __getnewargs__(self) -> Any:
        return str(self), self.code, self.numbers
