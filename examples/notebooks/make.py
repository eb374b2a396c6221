"""The tutorial as a notebook: runs the programs of docs/tutorial.md, one after the other, as Jupyter does.

    python examples/notebooks/make.py            compares what they print with the page, and the notebook with what it should be
    python examples/notebooks/make.py --short    runs the first SHORT programs only; compares the text of all
    python examples/notebooks/make.py --write    writes both anew

Needs nbclient, nbformat and ipykernel (examples/notebooks/requirements.txt) and the package fabric_kernel.
"""

import argparse
import pathlib
import re
import sys
import tempfile

import nbformat
from nbclient import NotebookClient

TOP = pathlib.Path(__file__).parents[2]
PAGE, NOTEBOOK = TOP / "docs/tutorial.md", TOP / "examples/notebooks/tutorial.ipynb"
SHORT = 2
# A program of the page, and what it prints.
PROGRAM = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)


def printed(cell):
    return "".join(output["text"] for output in cell.outputs if output.output_type == "stream" and output.name == "stdout")


def ran(page, programs):
    """The page as a notebook of which so many programs have run; the others have the output of the page."""
    cells, end = [], 0
    for program in PROGRAM.finditer(page):
        cells += [
            nbformat.v4.new_markdown_cell(linked(page[end : program.start()])),
            nbformat.v4.new_code_cell(program[1].rstrip()),
        ]
        end = program.end()
    cells.append(nbformat.v4.new_markdown_cell(linked(page[end:])))
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    # Two cells a program: text and code.
    notebook = nbformat.v4.new_notebook(cells=cells[: 2 * programs])
    with tempfile.TemporaryDirectory() as folder:
        NotebookClient(
            notebook, timeout=1800, kernel_name="python3", resources={"metadata": {"path": folder}}, record_timing=False
        ).execute()
    # Progress, and what differs from machine to machine.
    notebook.cells = notebook.cells + cells[2 * programs :]
    on_page = [program[2] for program in PROGRAM.finditer(page)][programs:]
    notebook.metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python"},
    }
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "code":
            text = printed(cell) if number < 2 * programs else on_page.pop(0)
            cell.execution_count = number // 2 + 1
            cell.outputs = [nbformat.v4.new_output("stream", name="stdout", text=text)] if text else []
    return notebook


def linked(text):
    """Links and pictures as seen from the notebook's folder."""
    return re.sub(r"\]\((?!\w+:|#)([^)]*)\)", r"](../../docs/\1)", text).strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--write", action="store_true")
    which.add_argument("--short", action="store_true")
    given = parser.parse_args()
    page = PAGE.read_text()
    notebook = ran(page, SHORT if given.short else len(PROGRAM.findall(page)))
    outputs = iter([printed(cell) for cell in notebook.cells if cell.cell_type == "code"])

    def with_output(program):
        text = next(outputs)
        return f"```python\n{program[1]}```\n" + (f"\n```text\n{text}```\n" if text else "")

    new_page, new_notebook = PROGRAM.sub(with_output, page), nbformat.writes(notebook) + "\n"
    if given.write:
        PAGE.write_text(new_page)
        NOTEBOOK.write_text(new_notebook)
        return
    if new_page != page:
        old, new = page.splitlines(), new_page.splitlines()
        print("\n".join(f"- {a}\n+ {b}" for a, b in zip(old, new) if a != b))
        sys.exit("docs/tutorial.md is not what its programs print: examples/notebooks/make.py --write")
    if new_notebook != NOTEBOOK.read_text():
        sys.exit("examples/notebooks/tutorial.ipynb is not docs/tutorial.md: examples/notebooks/make.py --write")


if __name__ == "__main__":
    main()
