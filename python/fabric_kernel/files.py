"""Files that are whole or as they were before."""

import contextlib
import csv
import errno
import gzip
import io
import itertools
import math
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TextIO

Place = str | os.PathLike[str]

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors of a disk that is full or broken: failures, and nothing that is refused."""


def shown(name: Place) -> str:
    """The name of a file for titles and messages, whatever its bytes."""
    return os.fsencode(name).decode(errors="backslashreplace")


def filled(value: object) -> object:
    """A cell of a table: empty for a number that is not finite."""
    return "" if isinstance(value, float) and not math.isfinite(value) else value


def titled(scene: Place) -> str:
    """The name of a scene's file without its folder, for titles."""
    return shown(os.path.basename(scene)) or shown(scene)


class Output(io.TextIOBase):
    """Standard output of a command: what cannot be written is raised by `finish`, once its files are there."""

    def __init__(self, stream: TextIO | None) -> None:
        self.stream, self.error = stream, None if stream else OSError(errno.EBADF, "is closed")

    def write(self, text: str) -> int:
        encoding = getattr(self.stream, "encoding", None) or "utf-8"
        try:
            if self.stream and not self.error:
                self.stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
                self.stream.flush()
        except OSError as error:
            self.error = error
        return len(text)

    def finish(self) -> None:
        if self.error:
            if self.stream:  # Python writes the rest at its end.
                os.dup2(os.open(os.devnull, os.O_WRONLY), self.stream.fileno())
            self.error.filename = "standard output"
            raise self.error


@contextlib.contextmanager
def naming(path: Place) -> Iterator[None]:
    """An OSError, as of a full disk, gets the name of the file."""
    try:
        yield
    except OSError as error:
        error.filename = str(path)
        raise


@contextlib.contextmanager
def reading(path: Place) -> Iterator[None]:
    """What is wrong with a file of results gets its name: a ValueError."""
    try:
        yield
    except (AttributeError, EOFError, LookupError, TypeError, ValueError, gzip.BadGzipFile, zlib.error) as error:
        raise ValueError(f"{path}: is cut off, or not as this version writes it") from error


def apart(read: Iterable[Place | None], outputs: Iterable[Path]) -> None:
    """Raises ValueError if a file that is written is one of those that are read, by any name."""
    for path, output in itertools.product([Path(path) for path in read if path], outputs):
        if output.resolve() == path.resolve() or (output.exists() and path.exists() and output.samefile(path)):
            raise ValueError(f"{output}: would be written over {path}, which is read: give another place")


def csv_of(heading: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as the text of a CSV file."""
    text = io.StringIO()
    csv.writer(text).writerows([heading, *rows])
    return text.getvalue()


def written(path: Place, content: str | bytes) -> None:
    """Writes a file under another name beside it, then puts it in its place. Raises OSError with the path."""
    path = Path(path)
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with naming(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with beside.open("wb") as file:
                file.write(content if isinstance(content, bytes) else content.encode())
                file.flush()
                os.fsync(file.fileno())
            os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)
