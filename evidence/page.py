"""Tables in Markdown and plots of rows, for the documents."""

import math

from fabric_kernel import drawing
from fabric_kernel.page import Page, power, printed

__all__ = ["Page", "errors", "lines", "markdown", "power", "printed", "same", "shown", "significant", "table"]


def markdown(heading, rows, text=0):
    """A table. text: how many columns from the left hold words."""
    cells = [[str(cell).replace("|", "\\|").replace("\n", "<br>") for cell in row] for row in rows]
    below = ["---" if k < max(text, 1) else "---:" for k in range(len(heading))]
    return "".join("| " + " | ".join(row) + " |\n" for row in [heading, below, *cells])


def table(rows, columns, text=1):
    """columns: (heading, key or function of a row, digits); the heading alone where it is the key."""
    of = lambda row, heading, *key: key[0](row) if key and callable(key[0]) else row[(heading, *key)[-1]]
    cells = [[shown(of(row, *column[:-1]), column[-1]) for column in columns] for row in rows]
    return markdown([column[0] for column in columns], cells, text)


def shown(value, digits):
    """digits: of a fixed number; "e2" for a power of ten with two; None for words. What is no number is left empty."""
    if isinstance(value, str) or value is None or not math.isfinite(value):
        return value if isinstance(value, str) else ""
    return power(value, int(digits[1:])) if isinstance(digits, str) else f"{value:.{digits}f}"


def same(names, digits):
    return [(name, digits) for name in names]


def significant(value, digits=3):
    """So many significant figures, and all digits before the point."""
    return f"{value:.{max(0, min(4, digits - 1 - exponent(value)))}f}"


def exponent(value):
    return int(f"{abs(value):.6e}".split("e")[1]) if value else -9


def lines(rows, name, x, y):
    """A marked series for each name, in the order of the rows; name and x: keys or functions of a row."""
    found = {}
    of = lambda row, key: key(row) if callable(key) else row[key]
    for row in rows:
        found.setdefault(of(row, name), []).append((of(row, x), y(row)))
    return [drawing.Series(name, points) for name, points in found.items()]


def errors(path, title, x, y, lines, levels=()):
    """A logarithmic plot of marked lines and dashed levels; nothing if no line has a positive point."""
    lines = [line for line in lines if any(px > 0 and py > 0 for px, py in line.points)]
    if lines:
        drawing.draw(path, title, x, y, lines, "logarithmic", levels=levels)
