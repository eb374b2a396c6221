"""Long tables of the documents: a page shows what a reader needs of them, and the whole table is a CSV beside the page.

`python -m evidence.short` shortens the tables of docs/tables that are still whole.
"""

import csv
import io
import pathlib
import re

TOP = pathlib.Path(__file__).parents[1]
LEFT_OUT = ((), None)
SHOTS = ("6", "10", "15", "20", "60")
"""Lengths of tests that are shown."""
LINES = 1
"""Lines of a cell that are shown."""
SHORT = {
    "accuracy_coupling": {"scheme": ((0, 1, 3, 4), None)},
    "accuracy_grading": {"case": ((0, 1, 2, 6, 9, 11), None)},
    "accuracy_impact": {"bars, step": ((0, 1, 3, 4, 8), None)},
    "accuracy_overshoot_breaking": {"viscosity": ((0, 1, 2, 3, 4, 7, 9), None)},
    "accuracy_overshoot_strain": {"viscosity": ((0, 1, 2, 3, 5, 9), lambda row: row[2] != "4")},
    "accuracy_pointwise": {"case": ((0, 1, 4, 5, 7), None)},
    "friction": {"velocity, m/s": LEFT_OUT},
    "mesh": {"plies": (range(7), lambda row: row[2] == "assumed")},
    "oneply": {"width, mm": (range(6), None)},
    "own_tests": {"tests": ((0, 1, 3, 5, 7, 8, 9, 10, 11, 12), lambda row: row[0] in ("2", "3", "5", "10"))},
    "paper_claims": {" | claim": (range(5), None)},
    "paper_map": {"washers | uniform": (range(10), lambda row: row[3] in ("detached", "strain and dissipated, detached"))},
    "performance": {"nodes | scalar": ((0, 3, 4, 5), None), "nodes |  | ns": LEFT_OUT, "figure | value": LEFT_OUT},
    "plies": {"form": ((0, 1, 2, 3, 5, 7), None)},
    "stability": {"velocity, m/s": LEFT_OUT},
    "v50": {
        "design | link | shots | guess": (range(7), lambda row: row[2] in SHOTS and row[3] in ("sd x 1", "-2 sd, sd x 0.5")),
        "design | link | shots | V01": (range(6), lambda row: row[2] in SHOTS),
    },
    "v50_bracket": {"start over V50": LEFT_OUT},
    "validation": {
        "yarn | viscosity": LEFT_OUT,
        "plies | viscosity": LEFT_OUT,
        "network | between": LEFT_OUT,
        "yarns a bar | width": ((0, 1, 2, 3, 5, 6, 7), None),
    },
}
"""Page: the start of a table's heading: columns that are shown, and which rows; without columns the CSV alone has the table."""
NAMED = {
    "accuracy_grading": dict(zip((3, 4), ("error of absorbed energy %", "error of velocity %"))),
    "accuracy_overshoot_breaking": {5: "first damage over Smith", 6: "first failure over Smith"},
}
"""Headings of columns that are shown without the one beside them."""


def cells(line):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def few(cell):
    lines = cell.split("<br>")
    return cell if len(lines) <= LINES + 1 else "<br>".join([*lines[:LINES], f"and {len(lines) - LINES} more"])


def shortened(name, text, part=""):
    """The text of a page with its long tables shortened, and the files beside it: name, text. Tables of one heading are one file,
    whose first column says under which title each row stood."""
    whole = {}

    def table(found):
        nonlocal part
        if found[1]:
            part = found[1]
            return found[0]
        columns, wanted = next((how for start, how in SHORT[name].items() if found[0].startswith(f"| {start}")), (None, None))
        if columns is None:
            return found[0]
        heading, _, *rows = map(cells, found[0].strip().split("\n"))
        if max(columns, default=0) >= len(heading):
            # A question in short form has fewer cases.
            return found[0]
        whole.setdefault(tuple(heading), []).extend([part, *row] for row in rows)
        if not columns:
            file = f"{name}_{list(whole).index(tuple(heading)) + 1}.csv"
            return f"In [{file}]({file}).\n"
        below = found[0].split("\n")[1].strip(" |").split(" | ")
        pick = lambda row: [few(row[c]) for c in columns]
        head = [NAMED.get(name, {}).get(place, cell) for place, cell in enumerate(pick(heading))]
        lines = [head, [below[c] for c in columns], *(pick(row) for row in rows if not wanted or wanted(row))]
        return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)

    text = re.sub(r"^#+ (.*)\n|(?:^\|.*\n)+", table, text.rstrip() + "\n", flags=re.MULTILINE) if name in SHORT else text
    files = {}
    for k, (heading, rows) in enumerate(whole.items(), 1):
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(
            [["table", *heading], *([cell.replace("<br>", "; ") for cell in row] for row in rows)]
        )
        files[f"{name}_{k}.csv"] = out.getvalue()
    listed = [f"[{file}]({file})" for file in files if f"({file})" not in text]
    return text.rstrip() + (f"\n\nWhole tables: {', '.join(listed)}.\n" if listed else "\n"), files


def write(docs, name, title, command, text):
    """docs/tables/NAME.md: a generated file, which says so; and CSV beside it."""
    text, files = shortened(name, text, title)
    folder = docs / "tables"
    folder.mkdir(parents=True, exist_ok=True)
    files[f"{name}.md"] = f"# {title}\n\nGenerated by `{command}`; do not edit.\n\n{text.rstrip()}\n"
    for file, whole in files.items():
        (folder / file).write_text(whole)
    print(f"written: {folder / name}.md")


def main():
    for name in SHORT:
        path = TOP / "docs/tables" / f"{name}.md"
        if not (whole := path.read_text()).count(f"({name}"):
            text, files = shortened(name, whole)
            path.write_text(text)
            for file, rows in files.items():
                path.with_name(file).write_text(rows)


if __name__ == "__main__":
    main()
