"""Texts contain few of the patterns that the style guide in `.github/CONTRIBUTING.md`
advises against.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest
from documents import DOCUMENTS, ROOT

ODD = re.compile(
    r"(?:^|[.:;!?]\s+|^\s*[*#|-]+\s+)(?:What|Who|Whoever)\s+(?!is\s+\w+\?|(?:are|does"
    r"|do)\b[^.]*\?|if\b)[a-z][^?.!;:]*[.;:!]"
    r"|\b(?:is|are|was) no "
    r"(?!longer|more|way|need|reason|doubt|problem|one|answer|file|log|run|such)[a-z]+"
    r"|\bso (?:many|much) (?!as\b|that\b|more\b|better\b)"
    r"|(?:^|[.;]\s+)Where (?!the|is|are|do|to|it)\w+[^.?]*,"
    r"|\b(?:stands?|stood|standing) (?:in|above|below|beside|there|over|once|twice)\b"
    r"|\b(?:goes?|going) with (?:the|each|these|those|others?)\b|\banew\b|\bonce "
    r"more\b|\bbeside\b|\bas where\b"
    r"|\b(?:tells?|told) (?!the user|you|the student|a student|people|everyone|apart)\w+"
    r"|\b(?:holds?|held) (?!down|on\b)\w+",
    re.MULTILINE,
)
CODE = sorted((ROOT / "gyrodata").rglob("*.py"))


def docstrings() -> Iterator[str]:
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    for path in CODE:
        nodes = (
            node
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
            if isinstance(node, kinds)
        )
        yield from (
            (ast.get_docstring(node) or "").partition("\n\n")[0] for node in nodes
        )


TEXTS = {
    path.stem: re.sub(
        r"```.*?```|`[^`]*`|<!--.*?-->", " ", path.read_text("utf-8"), flags=re.S
    )
    for path in DOCUMENTS
}
TEXTS["messages"] = "\n".join(
    path.read_text("utf-8") for path in (ROOT / "gyrodata").glob("*/messages.toml")
)
TEXTS["comments"] = "\n".join(
    text for path in CODE for text in re.findall(r"#\s+(.*)", path.read_text("utf-8"))
)
# Patterns per 1,000 words. A number here may only become smaller.
MOST = {"docstrings": 0.5, "comments": 1.0, "messages": 2.5}


@pytest.mark.parametrize("name", [*TEXTS, "docstrings"])
def test_text_has_few_odd_patterns(name: str) -> None:
    text = TEXTS[name] if name in TEXTS else "\n".join(docstrings())
    found = [match[0] for match in ODD.finditer(text)]
    assert 1000 * len(found) / len(re.findall(r"\w+", text)) <= MOST.get(name, 2.5), (
        found
    )
