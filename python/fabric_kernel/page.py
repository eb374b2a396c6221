"""Tables for the terminal, and an HTML page with everything inside."""

import base64
import html
import logging
import pathlib
from collections.abc import Sequence
from typing import Any

from .files import Place, written

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1d2733; max-width: 1240px; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; line-height: 1.25; } h2 { font-size: 1.3rem; margin-top: 2.6rem; border-bottom: 1px solid #d5dbe2; }
h3 { font-size: 1.08rem; margin-top: 1.6rem; }
p, figcaption, li { max-width: 62rem; }
figure { margin: 1.2rem 0; } figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #46505c; font-size: 0.93rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.87rem; margin: 0.8rem 0; }
th, td { text-align: right; padding: 0.25rem 0.6rem; border-bottom: 1px solid #e3e7eb; vertical-align: top; }
th { background: #f3f5f8; font-weight: 600; } td:first-child, th:first-child, td.text, th.text { text-align: left; }
td:not(.text) { white-space: nowrap; }
.answer { border-left: 4px solid #0072b2; background: #f3f7fb; padding: 0.3rem 1rem; }
.answer p:first-child { font-size: 1.35rem; font-weight: 600; }
summary { cursor: pointer; font-weight: 600; }
td.lines { min-width: 21rem; }
td.agrees { background: #e2f4ea; } td.doesnot { background: #fde5dc; } td.undecided { background: #fdf4d3; }
"""


def printed(heading: Sequence[Any], rows: Any) -> str:
    """Table with columns in line, for the terminal."""
    rows = [[str(cell) for cell in row] for row in [heading, *rows]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(heading))]
    lines = [
        "  ".join(cell.ljust(width) if k == 0 else cell.rjust(width) for k, (cell, width) in enumerate(zip(row, widths)))
        for row in rows
    ]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]]) + "\n"


def power(value: float, digits: int) -> str:
    """1.2e-3: with a short exponent."""
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def escaped(text: object) -> str:
    # A number stays with its per cent sign.
    return html.escape(str(text), quote=False).replace(" %", "\u00a0%").replace("\n", "<br>")


def notebook(title: str, answer: Sequence[str], heading: Sequence[str], rows: Any) -> str:
    """Answer and table of a result, as a notebook shows it."""
    page = Page(title)
    page.answer(answer)
    page.table(heading, rows)
    return "".join(page.parts)


class Page:
    """The page under construction."""

    def __init__(self, title: str) -> None:
        self.title, self.folded = title, ""
        self.parts = [f"<h1>{escaped(title)}</h1>"]

    def section(self, title: str) -> None:
        self.parts.append(f"<h2>{escaped(title)}</h2>")

    def heading(self, title: str) -> None:
        self.parts.append(f"<h3>{escaped(title)}</h3>")

    def text(self, text: str) -> None:
        self.parts.append(f"<p>{escaped(text)}</p>")

    def answer(self, lines: Any) -> None:
        """What a reader came for, in a box; the first line is the largest."""
        self.parts.append('<div class="answer">' + "".join(f"<p>{escaped(line)}</p>" for line in lines) + "</div>")

    def fold(self, title: str) -> None:
        """What follows is folded below this title, until another one."""
        self.parts.append(f"{self.folded}<details><summary>{escaped(title)}</summary>")
        self.folded = "</details>\n"

    def figure(self, path: pathlib.Path, caption: str) -> None:
        """A picture, kept inside the page."""
        self.picture(path.read_bytes(), path.suffix, caption)

    def picture(self, data: bytes, suffix: str, caption: str = "") -> None:
        """Picture of its bytes."""
        kind, text = {".svg": "image/svg+xml", ".gif": "image/gif"}.get(suffix, "image/png"), base64.b64encode(data).decode()
        below = f"<figcaption>{escaped(caption)}</figcaption>" if caption else ""
        self.parts.append(f'<figure><img alt="" src="data:{kind};base64,{text}">{below}</figure>')

    def table(self, heading: Sequence[Any], rows: Any, text: Any = ()) -> Any:
        """text: columns besides the first that hold words."""
        words = lambda k: ' class="text"' if k in text else ""
        lines = ["".join(f"<th{words(k)}>{escaped(cell)}</th>" for k, cell in enumerate(heading))]
        for row in rows:
            line = ""
            for k, cell in enumerate(row):
                kind = words(k)
                if cell in ("agrees", "does not", "undecided"):
                    kind = f' class="text {cell.replace(" ", "")}"'
                elif "\n" in str(cell):
                    kind = ' class="text lines"'
                line += f"<td{kind}>{escaped(cell)}</td>"
            lines.append(line)
        self.parts.append('<div class="scroll"><table>' + "".join(f"<tr>{line}</tr>\n" for line in lines) + "</table></div>")

    def html(self) -> str:
        head = (
            f'<meta charset="utf-8"><meta name="viewport" content="width=device-width, '
            f'initial-scale=1"><title>{escaped(self.title)}</title><style>{STYLE}</style>'
        )
        body = "\n".join([*self.parts, self.folded])
        return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'

    def write(self, path: Place) -> None:
        written(path, self.html())
        logging.getLogger("fabric_kernel").info("written: %s", path)
