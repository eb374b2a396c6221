"""Every fence of a page is run as a reader would, in the order of the page; what it prints is what the page says.

A comment directly before a fence, `<!-- not run: why -->`, leaves it out, and `<!-- long -->` does so without `--long`.
A text fence or a table directly after a fence has lines that it prints; of a Python program, and in docs/tables, all.
A file has its name in the line before it, as `mine.toml`:. `--write` writes these, and the notebook of the tutorial, anew.
"""

import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys

import fabric_kernel as fk
import pytest

TOP = pathlib.Path(__file__).resolve().parents[2]
PAGES = subprocess.run(["git", "ls-files", "*.md"], cwd=TOP, capture_output=True, text=True, check=True).stdout.split()
FENCE = re.compile(
    r"(?:`(?P<file>[\w.]+)`:\n\n)?(?:^<!-- (?P<note>long|not run: [^\n]+) -->\n)?^```(?P<language>\w+)\n(?P<code>.*?)^```\n"
    r"(?P<said>\n```text\n(?P<text>.*?)^```\n|\n(?P<table>(?:\|.*?\n)+))?",
    re.DOTALL | re.MULTILINE,
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder that looks like the clone, a home in it, and the programs of this Python first on the path."""
    for entry in TOP.iterdir():
        if not entry.name.startswith("."):
            (tmp_path / entry.name).symlink_to(entry)
    programs, home = tmp_path / "programs", tmp_path / "home"
    home.mkdir()
    programs.mkdir()
    start = "import sys; sys.argv[0] = 'fabric'; from fabric_kernel.program import main; sys.exit(main())"
    python = f"exec '{sys.executable}'"
    clone = f"cd '{TOP}' && HOME='{os.environ['HOME']}' PATH='{os.environ['PATH']}' exec cargo"
    for name, program in {"fabric": f'{python} -c "{start}"', "python": python, "python3": python, "cargo": clone}.items():
        (programs / name).write_text(f'#!/bin/sh\n{program} "$@"\n')
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def printed(fence, folder, names):
    """What a fence prints; names: what the programs of the page have defined."""
    language, code = fence["language"], fence["code"]
    if language == "sh":
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", code], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout
    if language == "python":
        with contextlib.redirect_stdout(io.StringIO()) as said:
            exec(compile(code, "fence", "exec"), names)
        return said.getvalue()
    assert fence["file"] or language == "toml", f"a {language} fence without the name of a file in the line before it"
    if language == "toml":
        fk.Simulation(fk.Scene.parse(code))
    if fence["file"]:
        (folder / fence["file"]).write_text(code)
    return ""


@pytest.mark.parametrize("page", [page for page in PAGES if "\n```" in (TOP / page).read_text()])
def test_page(page, folder, request, subtests):
    path, names = TOP / page, {"__name__": "__main__"}
    text = new = path.read_text()
    fences = list(FENCE.finditer(text))
    assert len(re.findall(r"^```\w", text, re.MULTILINE)) == sum(1 + (fence["text"] is not None) for fence in fences)
    counted = [str(fence["note"]).partition(":")[0] for fence in fences]
    print(f"{page}: {len(fences)} fences, {counted.count('long')} long, {counted.count('not run')} not run")
    for fence in fences:
        with subtests.test(line=text.count("\n", 0, fence.start("language")) + 1):
            if fence["note"] == "long" and not request.config.getoption("long"):
                pytest.skip("long: pytest tests/pages --long")
            if str(fence["note"]).startswith("not run"):
                continue
            said = printed(fence, folder, names)
            whole = fence["language"] == "python" or page.startswith("docs/tables/")
            wanted = fence["text"] or fence["table"] or ""
            if request.config.getoption("write") and whole:
                written = f"\n```text\n{said}```\n" if said else ""
                new = new.replace(fence[0], fence[0].removesuffix(fence["said"] or "") + written)
            elif whole:
                assert said == wanted
            else:
                assert wanted.rstrip() in said, [line for line in wanted.splitlines() if line not in said]
    if new != text:
        path.write_text(new)


def test_notebook(request):
    """The notebook of the tutorial is its page, with the same outputs."""
    text, cells, end = (TOP / "docs/tutorial.md").read_text(), [], 0

    def cell(kind, source, **rest):
        cells.append({"cell_type": kind, "id": f"cell-{len(cells)}", "metadata": {}, "source": source, **rest})

    def prose(part):
        """Links and pictures as seen from the notebook's folder."""
        part = re.sub(r"^<!--.*?-->\n", "", part, flags=re.MULTILINE)
        cell("markdown", re.sub(r"\]\((?!\w+:|#)([^)]*)\)", r"](../../docs/\1)", part).strip().splitlines(keepends=True))

    for number, fence in enumerate((fence for fence in FENCE.finditer(text) if fence["language"] == "python"), 1):
        prose(text[end : fence.start()])
        lines = (fence["text"] or "").splitlines(keepends=True)
        outputs = [{"name": "stdout", "output_type": "stream", "text": lines}] if lines else []
        cell("code", fence["code"].rstrip().splitlines(keepends=True), execution_count=number, outputs=outputs)
        end = fence.end()
    prose(text[end:])
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    notebook = {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    written = json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    file = TOP / "examples/notebooks/tutorial.ipynb"
    if request.config.getoption("write"):
        file.write_text(written)
    assert file.read_text() == written, "pytest tests/pages --write writes it"
