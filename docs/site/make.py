"""`cargo xtask site`: the pages as a site with a search, which opens from a file too. Writes target/site/html and an archive of
it; a broken link is an error.

Pages keep their paths; what they link to lies beside them. The reference of the package, the header and a link to rustdoc are
added.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile

TOP = pathlib.Path(__file__).resolve().parents[2]
HERE, OUT = TOP / "docs/site", TOP / "target/site"
PAGES = OUT / "pages"
LINK = re.compile(r"\]\((?!\w+:|#)([^)#\s]+)")
# Parts of the package that a reader calls.
MODULES = ["", *".runs .ensembles .designs .limit .v50 .residual .sensitivity .model_error .oneply .plot .movie .textile".split()]
# From npm: the search in a page that was opened as a file, and equations.
SHIM, KATEX = "iframe-worker@1.0.4", "katex@0.16.22"
SET = """document$.subscribe(() => renderMathInElement(document.body, {
  delimiters: [{ left: "\\\\(", right: "\\\\)", display: false }, { left: "\\\\[", right: "\\\\]", display: true }],
  throwOnError: false,
}))
"""
STYLE = (
    ".md-grid { max-width: 76rem; } .md-typeset table:not([class]) th { min-width: 0; } .md-typeset img { max-height: 28rem; }\n"
)
# On a telephone tables are dense, and names in them are whole.
STYLE += "@media (max-width: 44rem) { .md-typeset table:not([class]) :is(th, td) { padding: .4em .5em; } }\n"
STYLE += "@media (max-width: 44rem) { .md-typeset table code { word-break: normal; } }\n"


def put(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def package(name, wanted):
    """Files of a package of npm, in a folder."""
    packed = subprocess.run(
        ["npm", "pack", name, "--silent", "--pack-destination", OUT], capture_output=True, text=True, check=True
    ).stdout.strip()
    with tarfile.open(OUT / packed) as archive:
        names = [member.name for member in archive if re.fullmatch(wanted, member.name)]
        archive.extractall(OUT / "npm", names, filter="data")
    return [OUT / "npm" / name for name in names]


def stage():
    shutil.rmtree(OUT, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=TOP, capture_output=True, text=True, check=True).stdout.split()
    for name in listed:
        if (TOP / name).is_file() and not name.startswith("xtask"):
            text = (TOP / name).read_text()
            put(PAGES / name, text)
            for link in LINK.findall(text):
                target = (TOP / name).parent / link
                if target.is_file() and target.suffix != ".md":
                    copy = PAGES / target.resolve().relative_to(TOP)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(target, copy)
    # Of the evidence, as far as it was answered here.
    for table in (TOP / "target/evidence").glob("*/*.md"):
        put(PAGES / "evidence/tables" / table.name, table.read_text())
    modules = [name for name in MODULES if not name or list((TOP / "python/fabric_kernel").glob(f"{name[1:]}.py"))]
    put(
        PAGES / "reference/python.md", "# Python package\n\n" + "\n\n".join(f"::: fabric_kernel{name}" for name in modules) + "\n"
    )
    put(PAGES / "reference/c.md", f"# C header\n\n```c\n{(TOP / 'include/fabric_kernel.h').read_text()}```\n")
    put(
        PAGES / "reference/rust.md",
        "# Rust crate\n\n`cargo doc -p fabric-kernel --no-deps` writes the reference of the crate; on this site it is <a "
        'href="../rustdoc/fabric_kernel/index.html">here</a>.\n',
    )
    put(PAGES / "site.css", STYLE)
    for name in package(SHIM, r"package/shim/index\.js"):
        shutil.move(name, PAGES / "iframe-worker.js")
    for name in package(KATEX, r"package/dist/(katex\.min\.(js|css)|contrib/auto-render\.min\.js|fonts/.*\.woff2)"):
        path = PAGES / "katex" / name.relative_to(OUT / "npm/package/dist")
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(name, path)
    put(PAGES / "katex/set.js", SET)
    put(OUT / "mkdocs.yml", (HERE / "mkdocs.yml").read_text().replace("PYTHON", str(TOP / "python")))


def archive():
    """Without what depends on the time."""
    with zipfile.ZipFile(OUT / "fabric-documentation.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(file for file in (OUT / "html").rglob("*") if file.is_file() and not file.name.startswith("sitemap")):
            packed.writestr(
                zipfile.ZipInfo(f"fabric-documentation/{file.relative_to(OUT / 'html').as_posix()}"),
                file.read_bytes(),
                zipfile.ZIP_DEFLATED,
            )


def main():
    stage()
    subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--config-file", OUT / "mkdocs.yml"],
        check=True,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
    )
    for page in (OUT / "html").rglob("*.html"):
        assert not re.search(r'src="(?:https?:)?//|<link[^>]*href="(?:https?:)?//', page.read_text()), (
            f"{page} loads something from elsewhere"
        )
    if (TOP / "target/rustdoc/doc").is_dir():
        shutil.copytree(TOP / "target/rustdoc/doc", OUT / "html/rustdoc", ignore=shutil.ignore_patterns(".*", "src"))
    archive()
    print(f"{sum(1 for file in (OUT / 'html').rglob('*.html'))} pages: {OUT / 'html/index.html'}")


if __name__ == "__main__":
    main()
