"""A small reader of LaTeX for tests: is it balanced?"""

from __future__ import annotations

import re

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|.", re.DOTALL)


def faults_of_document(document: str) -> list[str]:
    """List braces and environments that are not closed in their order."""
    found, braces, stack = [], 0, [""]
    for token in _TOKEN.findall(document):
        braces += (token == "{") - (token == "}")
        if braces < 0:
            found.append("a brace too many is closed")
    for kind, name in re.findall(r"\\(begin|end)\{(\w+)\}", document):
        if kind == "begin":
            stack.append(name)
        elif stack.pop() != name:
            return [*found, f"{name} is closed and not open"]
    return found + [f"{name} is left open" for name in stack[1:]] + ["a brace is left open"] * (braces > 0)
