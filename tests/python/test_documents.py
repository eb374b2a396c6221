"""The programs of the documents, as a reader would run them, and their links."""

import ast
import graphlib
import pathlib
import re
import subprocess
import sys

import fabric_kernel as fk

TOP = pathlib.Path(__file__).parents[2]
SOURCES = {".rs", ".py", ".h", ".hpp", ".c", ".ts"}


def files():
    """Files of the clone, without what is built."""
    listed = subprocess.run(["git", "ls-files"], cwd=TOP, capture_output=True, text=True, check=True).stdout.split("\n")
    return [TOP / name for name in listed if (TOP / name).is_file()]


def headings(page):
    return re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL), re.MULTILINE)


def anchors(page):
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings(page)}


def test_readme(tmp_path):
    """The program and the commands of the README print what it says; what they write is in a folder of its own."""
    text = (TOP / "README.md").read_text()
    blocks = re.findall(r"^```(?:python|sh)\n([^`]*)```\n\n```text\n([^`]*)```", text, re.MULTILINE)
    assert (len(blocks), text.count("```python\n")) == (2, 1)
    for code, said in blocks:
        name, *options = code.split()
        program = ["-m", "fabric_kernel.program", *options, "--out", tmp_path / options[0]] if name == "fabric" else ["-c", code]
        done = subprocess.run([sys.executable, *program], cwd=TOP, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert said.strip() in done.stdout


def test_programs(tmp_path):
    """Whole programs of docs/python.md run."""
    blocks = re.findall(r"```python\n(.*?)```", (TOP / "docs" / "python.md").read_text(), re.DOTALL)
    blocks = [block for block in blocks if "import fabric_kernel" in block]
    assert len(blocks) == 2
    for block in blocks:
        script = tmp_path / "example.py"
        script.write_text(block)
        done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert done.stdout


def test_numbers():
    """Numbers on pages whose programs are no whole ones."""
    page = (TOP / "data/fabrics/README.md").read_text()
    scene = fk.Scene.parse(re.findall(r"```toml\n(.*?)```", page, re.DOTALL)[0])
    inviscid = scene.replace({f"yarn.viscosity_{kind}": 0.0 for kind in ("linear", "quadratic", "bending")})
    absorbed = [f"{fk.fly(one).absorbed:.2f} J" for one in (scene, inviscid)]
    assert f"absorbs {absorbed[0]}, without viscosity {absorbed[1]}." in page
    page = (TOP / "docs/python.md").read_text()
    (program,) = (block for block in re.findall(r"```py\n(.*?)```", page, re.DOTALL) if "body" in block)
    names = {"fk": fk}
    exec(program.rpartition("rows")[0], names)
    for held, kind in (("two", "two_sides"), ("four", "four_sides")):
        row = fk.fly(names["scene"].replace({"attachment.kind": kind}), until=["detached"])
        assert f"| {held} | {row.speed:.2f} m/s, {row.absorbed:.2f} J |" in page


def test_links():
    """Each link of a page leads to a file, and to a heading of it."""
    for page in (file for file in files() if file.suffix == ".md"):
        for path, anchor in re.findall(r"\]\((?!\w+:)([^)#]*)#?([^)]*)\)", page.read_text()):
            led = (page.parent / path).resolve() if path else page
            assert led.exists(), (page, path)
            assert not anchor or anchor in anchors(led), (page, path, anchor)


def test_mentions():
    """Each page and section that a source names is there: docs/model.md, "The step"."""
    for source in (file for file in files() if file.suffix in SOURCES):
        for path, section in re.findall(r'(docs/\w+\.md)(?:, \\?"([^"\\]*))?', source.read_text()):
            assert (TOP / path).is_file(), (source, path)
            assert not section or section in headings(TOP / path), (source, path, section)


def test_pictures():
    """Each picture is shown on a page."""
    pages = "".join(file.read_text() for file in files() if file.suffix == ".md")
    for picture in (TOP / "docs" / "images").iterdir():
        assert f"images/{picture.name}" in pages, picture.name


def test_no_import_of_the_package_leads_back():
    """Imports inside of functions and for types count too."""
    files = {file.stem: ast.parse(file.read_text()) for file in (TOP / "python/fabric_kernel").glob("*.py")}
    imports = {
        name: {part for one in ast.walk(tree) if isinstance(one, ast.ImportFrom) and one.level for part in named(one)}
        for name, tree in files.items()
    }
    graphlib.TopologicalSorter({name: found & set(files) for name, found in imports.items()}).prepare()


def named(one):
    return [one.module] if one.module else [alias.name for alias in one.names]
