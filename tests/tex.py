"""A small reader of LaTeX for tests: is it balanced, and does it hold nothing but what is meant?"""

from __future__ import annotations

import re

HARMLESS = re.compile(
    r"\\(?:text[a-z]+|nobreakspace|quotedblbase|guillemot(?:left|right)|ensuremath|times|pm|cdot|propto|le|ge|approx|ne|infty|surd|to"
    r"|dots|S|pounds|ss|ae|AE|oe|OE|o|O|l|L|dj|DJ|dh|DH|th|TH|i|grave|acute|bar|ddot|dot|cyrillictext"
    r"|[a-z]*(?:alpha|beta|gamma|delta|epsilon|zeta|eta|theta|iota|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|upsilon|phi"
    r"|chi|psi|omega)|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Upsilon|Phi|Psi|Omega|cyr[a-z]+|CYR[A-Z]+|[urHvck])\Z"
    r"|\\[`'^~=.\"{}$&#%_]\Z"
)
"""Commands that print one sign."""

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|.", re.DOTALL)


def faults_of_text(escaped: str) -> list[str]:
    """What in an escaped text TeX would obey, and what is open or not ASCII."""
    for symbol in (r"\ensuremath{I_{zz}}", r"\ensuremath{M_0}"):
        escaped = escaped.replace(symbol, "")
    found = faults_of_document(escaped)
    for token in _TOKEN.findall(escaped):
        if token[0] == "\\" and not HARMLESS.match(token):
            found.append(f"command {token}")
        if token in tuple("%#$&~^_\n\r\t") or not token.isprintable():
            found.append(f"active {token!r}")
    return found


def faults_of_document(document: str) -> list[str]:
    """Braces and environments that do not go together, and signs beyond ASCII."""
    found, braces, stack = [] if document.isascii() else ["not ASCII"], 0, [""]
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
