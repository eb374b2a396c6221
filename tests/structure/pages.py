"""`python3 tests/structure/pages.py`: each page keeps its budget of words, and its sentences are short, plain and in the words of
the field. What programs print is in those words, too.

Words are those of `wc -w` without comments. Sentences are checked outside of code and tables. `--all` prints the words of each
page.
"""

import ast
import pathlib
import re
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
BUDGET = {
    "README.md": 706,
    "docs/model.md": 4490,
    "docs/validation.md": 1909,
    "docs/tutorial.md": 1528,
    "docs/fmi.md": 1432,
    "docs/accuracy.md": 1300,
    "docs/embedding.md": 1340,
    "docs/v50.md": 1215,
    "docs/compare.md": 453,
    "docs/python.md": 1218,
    "docs/reliability.md": 1000,
    "docs/performance.md": 730,
    "data/fabrics/README.md": 940,
    "CONTRIBUTING.md": 662,
    "examples/README.md": 150,
    "examples/rotorburst/README.md": 355,
    "docs/dependencies.md": 439,
    "docs/web.md": 367,
    "CHANGELOG.md": 350,
    "data/measured/README.md": 250,
    # Beside what they describe.
    "evidence/resolved/README.md": 890,
    "fmu/wasm/README.md": 307,
    "examples/reference/README.md": 160,
    "kernel/README.md": 155,
    "xtask/release/README.md": 130,
    "examples/coupling/README.md": 82,
    "SECURITY.md": 95,
    "python/README.md": 37,
}
TABLES, ALL_TABLES = "docs/tables/", 18_600
"""Tables are written by programs: all of them together have one budget (evidence/short.py shortens them)."""
LINKS = {"README.md": 15}
PROGRAMS = [
    f"{folder}/*.{kind}"
    for folder in ("kernel", "crates", "capi", "fmu", "python", "evidence", "examples", "xtask", "web")
    for kind in ("py", "rs", "ts")
]
"""Whose messages are read."""
WORDS = 30
"""At most these in a sentence."""
NAMES = r"\b(FMI|Python|3 in|10 in|Kevlar|Cortex|Chrome|Firefox|Safari) ?[-.\d]*"
"""Names with a number in them."""
PRIVATE = re.compile(
    r"\b(ow(es|ed|ing)|giv(es?|ing) (back|way)|stands? \d|stood|(is|are|was) open\b|open by|book(s|ed)|told|tells?|hears?|could "
    r"be (read|had)"
    r"|hangs? together|an ask|rub(s|bed)?|besides|pace|push(es|ed|ing)?|settled|rough|drawn?|draws)\b",
    re.IGNORECASE,
)
"""Words for which the field has others: energy error, accumulated, ballistic limit of, energy residual, reported, available,
published, connected component, request, friction, relaxation factor, impulse, reaction, converged, sample."""


def sentences(text):
    """(line, sentence) of what is prose; code, formulas, links, names and references to literature are taken out of it."""
    text = re.sub(r"^```.*?^```|^(    |\|).*?$", lambda code: "\n" * code[0].count("\n"), text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"`[^`]*`|\$[^$\n]+\$", "code", text)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    text = re.sub(r" (± [\d.]+|\[[-−\d., ]+\])", "", text)
    text = re.sub(rf"\d+ \(\d{{4}}\)( \d+)?|\(\d{{4}}\)|\(M\d+\)|{NAMES}", "name", text)
    for number, line in enumerate(text.split("\n"), 1):
        for sentence in re.split(r"(?<=[.?!:])\**\s+(?=[*\[(`]*[A-Z0-9])|\*\*", line):
            yield number, sentence


def found(page, text):
    links = len(re.findall(r"(?<!!)\[[^\]]*\]\(", text))
    if links > LINKS.get(page, links):
        yield f"{page}: {links} links, limit {LINKS[page]}"
    for line, sentence in sentences(text):
        words = len(re.findall(r"[^\W\d_]{2,}", sentence))
        start = " ".join(sentence.split()[:6])
        if words > WORDS:
            yield f"{page}:{line}: a sentence of {words} words, limit {WORDS}: {start} ..."
        for private in PRIVATE.finditer(sentence):
            yield f"{page}:{line}: a private word, {private[0]!r}: {start} ..."


def messages(file, text):
    """(line, text) of string literals of several words, as the language joins them, with x for what is filled in."""
    if not file.endswith(".py"):
        text = re.sub(r"^\s*//.*$|'\"'", "", text, flags=re.MULTILINE)
        parts = list(re.finditer(r'"((?:[^"\\\n]|\\[\s\S])*)"', text))
        joined = [re.sub(r"\\\n\s*", "", part[1]).replace("\\n", "\n") for part in parts]
        found = [(text.count("\n", 0, part.start()) + 1, re.sub(r"\{[^}]*\}", "x", said)) for part, said in zip(parts, joined)]
    else:
        found, nodes = [], list(ast.walk(ast.parse(text)))
        inner = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
        inner |= {id(node.value) for node in nodes if isinstance(node, ast.Expr)}  # Comments in the form of strings.
        for node in nodes:
            if isinstance(node, ast.JoinedStr):
                found.append(
                    (node.lineno, "".join(part.value if isinstance(part, ast.Constant) else "x" for part in node.values))
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inner:
                found.append((node.lineno, node.value))
    # Neither names nor code nor lists of words.
    return [
        (line, said) for line, said in found if re.search(r"^\S+( \S+){1,12}$|[.,:;(].* ", said, re.DOTALL) and " = " not in said
    ]


def main():
    assert len(list(found("planted", f"It stands 3 m/s above 4,{' and so' * 14}."))) == 2, "what is wrong is not found"
    assert messages("a.py", '"""It told us."""\nraise E(f"{told}: it told us")') == [(2, "x: it told us")], (
        "a message is not found"
    )
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=TOP, capture_output=True, text=True, check=True).stdout.split()
    texts = {page: re.sub(r"<!--.*?-->", "", (TOP / page).read_text()) for page in listed if (TOP / page).is_file()}
    words = {page: len(text.split()) for page, text in texts.items()}
    tables = sum(count for page, count in words.items() if page.startswith(TABLES))
    wrong = [f"{TABLES}: {tables} words in all, limit {ALL_TABLES}"] if tables > ALL_TABLES else []
    for page, text in texts.items():
        if page.startswith(TABLES):
            continue
        limit = BUDGET.get(page)
        if limit is None or words[page] > limit:
            wrong.append(
                f"{page}: {words[page]} words, limit {limit}" if limit else f"{page}: has no budget in tests/structure/pages.py"
            )
        wrong += found(page, text)
        if "--all" in sys.argv:
            print(f"{page:32} {words[page]:6} words of {limit}")
    for file in subprocess.run(
        ["git", "ls-files", *PROGRAMS], cwd=TOP, capture_output=True, text=True, check=True
    ).stdout.split():
        for line, said in messages(file, (TOP / file).read_text()):
            wrong += found(f"{file}:{line}", said)
    print("\n".join(wrong) or f"{len(words)} pages keep their budgets: {sum(words.values()) - tables} words, of tables {tables}")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
