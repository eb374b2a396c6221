"""Links, mentions and pictures of the pages; tests/pages runs their programs."""

import ast
import graphlib
import pathlib
import re
import subprocess

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


def test_scenes():
    """Each example scene is in the index."""
    index = (TOP / "examples/README.md").read_text()
    assert all(f"](scenes/{scene.name})" in index for scene in (TOP / "examples/scenes").iterdir())


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
