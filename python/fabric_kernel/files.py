"""Files that are whole or as they were before."""

import contextlib
import csv
import io
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

Place = str | os.PathLike[str]


@contextlib.contextmanager
def naming(path: Place) -> Iterator[None]:
    """An OSError, as of a full disk, gets the name of the file."""
    try:
        yield
    except OSError as error:
        error.filename = str(path)
        raise


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
