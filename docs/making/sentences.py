"""All sentences of the program in one file, so that a rewording is one reviewed diff."""

import ast
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "sweep" / "stickslip"
PATH = Path(__file__).resolve().parents[2] / "tests" / "data" / "sentences.txt"
FEWEST_WORDS = 4
HEADING = """\
# Every text of four words and more that the program may show, in alphabetical order; braces hold what it fills in.
# Written by `make reference` from the sources; a test compares, so that a rewording is a change of a line here.
"""


def page() -> str:
    """Text of the file: one line for each sentence."""
    sources = (path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py"))
    lines = {sentence for source in sources for sentence in _sentences(ast.parse(source))}
    return HEADING + "".join(f"{line}\n" for line in sorted(lines, key=lambda line: (line.lower(), line)))


def _sentences(node: ast.AST) -> Iterator[str]:
    """Texts below a node; docstrings are none."""
    if isinstance(node, ast.JoinedStr | ast.Constant):
        text = " ".join(_text(node).split())
        if len(text.split()) >= FEWEST_WORDS:
            yield text
        return
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)):
            yield from _sentences(child)


def _text(node: ast.expr) -> str:
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part) for part in node.values)
    if isinstance(node, ast.FormattedValue):
        name = ast.unparse(node.value)
        return f"{{{name}}}" if name.replace(".", "_").isidentifier() else "{...}"
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
