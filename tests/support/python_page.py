"""The reference of the Python interface: signatures and tables of
gyrodata/docs/python.md, from the docstrings.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from itertools import chain, pairwise
from typing import Any

import gyrodata

ENTRY = re.compile(
    r"^(\S[^\n]*?)(?: : ([^\n]*))?\n((?:[ ]{4}[^\n]*\n?)+)", re.MULTILINE
)


def documentation(thing: Any) -> list[str]:
    """The docstring of a thing, behind those of the classes from which it inherits."""
    classes = thing.__mro__[::-1] if isinstance(thing, type) else (thing,)
    own = [one for one in classes if one.__module__.startswith("gyrodata")]
    return [inspect.getdoc(one) or "" for one in own]


def section(thing: Any, title: str) -> list[tuple[str, str, str]]:
    """Name, type and text of each entry in a section of a numpydoc docstring."""
    pattern = rf"^{title}\n-+\n(.*?)(?=\n\n\w[\w ]*\n---|\Z)"
    sections = [
        found[1]
        for text in documentation(thing)
        if (found := re.search(pattern, text, re.M | re.S))
    ]
    return [
        (name, kind, " ".join(text.split()))
        for part in sections
        for name, kind, text in ENTRY.findall(part)
    ]


def attributes(thing: type) -> Iterator[tuple[str, str, str]]:
    """Attributes of a class that have texts below them, those of its parents first."""
    for one in reversed(thing.__mro__):
        if one.__module__.startswith("gyrodata"):
            body = ast.parse(textwrap.dedent(inspect.getsource(one))).body[0].body  # type: ignore[attr-defined]
            for field, below in pairwise(body):
                if isinstance(field, ast.AnnAssign) and isinstance(below, ast.Expr):
                    text = " ".join(ast.literal_eval(below.value).split())
                    yield ast.unparse(field.target), ast.unparse(field.annotation), text


def methods(thing: type) -> Iterator[tuple[str, str, str]]:
    """Public methods and properties of a class, those of its parents first, with their
    docstrings up to the first section.
    """
    classes = [
        one for one in thing.__mro__[::-1] if one.__module__.startswith("gyrodata")
    ]
    for name, one in chain.from_iterable(vars(one).items() for one in classes):
        inner = one.fget if isinstance(one, property) else getattr(one, "func", one)
        text = (inspect.getdoc(inner) or "") if inspect.isfunction(inner) else ""
        if text and not name.startswith("_"):
            signature = inspect.signature(inner)
            arguments = ", ".join(list(signature.parameters)[1:])
            kind = str(signature.return_annotation)
            yield (
                name if inner is not one else f"{name}({arguments})",
                kind,
                prose(text),
            )


def prose(text: str) -> str:
    """A docstring up to its first section, on one line."""
    return " ".join(re.split(r"\n\n\w[\w ]*\n---", text)[0].split())


def table(head: str, rows: list[tuple[str, str, str]]) -> str:
    """A table of Markdown, or nothing without rows."""
    lines = [f"| {head} | type | meaning |", "|---|---|---|"]
    for name, kind, text in rows:
        kind = re.sub(
            r"`|\b\w+\.(?=[A-Z])", "", kind.replace(" | ", " or ").replace('"', "'")
        )
        lines.append(
            f"| `{name}` | {kind} | {text.replace('null', 'None')} |".replace("``", "`")
        )
    return "\n".join(lines) if rows else ""


def entry(name: str) -> str:
    """The signature, the tables and the errors of one public name."""
    thing = getattr(gyrodata, name)
    summary = prose(inspect.getdoc(thing) or "").replace("``", "`")
    if isinstance(thing, type):
        rows = [*(section(thing, "Attributes") or attributes(thing)), *methods(thing)]
        return "\n\n".join(filter(None, [summary, table("attribute", rows)]))
    signature = inspect.signature(thing)
    parameters = [
        one.replace(annotation=one.empty) for one in signature.parameters.values()
    ]
    call = str(
        signature.replace(parameters=parameters, return_annotation=signature.empty)
    )
    call = re.sub(r"={.*?}", "=…", call)
    words = f"```text\n{name}{call} -> {signature.return_annotation}\n```"
    errors = "\n".join(
        f"* `{kind}`: {text[0].lower()}{text[1:]}"
        for kind, _, text in section(thing, "Raises")
    )
    tables = table("parameter", section(thing, "Parameters"))
    return "\n\n".join(
        filter(None, [words, summary, tables, errors and f"Errors:\n\n{errors}"])
    )


def reference(page: str) -> str:
    """The page with new entries below its marks."""
    return re.sub(
        r"(<!-- reference: (\w+) -->\n).*?(?=\n```python|\n#|\Z)",
        lambda mark: f"{mark[1]}\n{entry(mark[2])}\n",
        page,
        flags=re.DOTALL,
    )
