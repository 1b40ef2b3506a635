r"""The report as a LaTeX document that a student can edit.

The document is in UTF-8, with values by `siunitx` and tables by `booktabs`.
"""

from __future__ import annotations

import re

from gyrodata.quantities.numerals import PLAIN
from gyrodata.reporting.content import report
from gyrodata.reporting.data import filled
from gyrodata.reporting.elements import (
    SYMBOLS,
    Head,
    Number,
    Part,
    Sentence,
    Styled,
    one_line,
)
from gyrodata.results import Analysis

_STYLES = {
    "typed": "{}",
    "quote": "{}",
    "code": r"\texttt{{{}}}",
    "strong": r"\textbf{{{}}}",
    "warn": r"\textbf{{{}}}",
}


def latex_report(analysis: Analysis) -> str:
    r"""Write the report as a LaTeX document.

    The macro ``\Izz`` contains the answer. Text from the log is escaped: TeX executes
    nothing in it.
    """
    whole = report(analysis)
    answer = next(_quantity(part) for part in whole.answer if isinstance(part, Number))
    # Braces and per cent mean something in LaTeX.
    signs = {
        "block_start_string": "<%",
        "block_end_string": "%>",
        "variable_start_string": "<<",
        "variable_end_string": ">>",
        "comment_start_string": "<#",
        "comment_end_string": "#>",
    }
    filters = {
        "sentence": lambda sentence: _sentence(sentence).replace(answer, r"\Izz{}"),
        "text": escape,
        "head": _head,
        "column_type": _column_type,
        "row": _row,
    }
    return filled("report.tex.jinja", filters, signs, whole=whole, answer=answer)


def _row(row: str) -> str:
    r"""Protect a row that TeX would read as an option of the ``\\`` before it."""
    if row.startswith(("[", "*")):
        return f"{{}}{row}"
    return row


def _column_type(head: Head) -> str:
    """Return the type of a column of a tabular: of fixed width, right or left."""
    if head.wrap:
        width = rf"{head.wrap:g}\linewidth"
        return rf">{{\raggedright\arraybackslash}}p{{{width}}}"
    return "r" if head.scale else "l"


def _sentence(sentence: Sentence) -> str:
    return "".join(map(_part, sentence)).strip()


def _part(part: Part) -> str:
    """Write a part of a sentence; only the words of the tool contain symbols."""
    if isinstance(part, Number):
        return _quantity(part)
    if isinstance(part, Styled):
        return _STYLES[part.style].format(as_typed(part.text))
    return escape(str(part))


def _quantity(number: Number) -> str:
    r"""Write a number for siunitx: "4.42 ± 0.03 mm" is ``\qty{4.42 +- 0.03}{…}``.

    A name, a bound ("< 0.1") or a plain number stays text.
    """
    if not PLAIN.fullmatch(number.shown[0]):
        return as_typed(str(number))
    power = number.exponent
    unit = ""
    if number.unit:
        power += number.scale.exponent
        unit = number.scale.siunitx
    times = f" e{power}" if power else ""
    if number.between == " to ":
        low, high = number.shown
        return rf"\qtyrange{{{low}{times}}}{{{high}{times}}}{{{unit}}}"
    digits = " +- ".join(number.shown) + times
    if unit:
        return rf"\qty{{{digits}}}{{{unit}}}"
    if digits != number.shown[0]:
        return rf"\num{{{digits}}}"
    return f"${digits}$" if digits.startswith(("-", "+")) else digits


def _head(head: Head) -> str:
    """Write the unit below the words: a column of numbers stays narrow."""
    words = escape(head.words)
    if not (head.scale and head.scale.unit):
        return words
    power = rf"\num{{e{head.scale.exponent}}}\," if head.scale.exponent else ""
    unit = rf"{{[}}{power}\unit{{{head.scale.siunitx}}}]"
    return rf"\shortstack[r]{{{words}\\{unit}}}"


# --- text from the tool and from the log ---

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_\allowbreak{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
}

_MATH = {
    "φ": r"\varphi",
    "ψ": r"\psi",
    "θ": r"\theta",
    "τ": r"\tau",
    "π": r"\pi",
    "χ": r"\chi",
    "σ": r"\sigma",
    "ω": r"\omega",
    "Ω": r"\Omega",
    "Δ": r"\Delta",
    "Σ": r"\Sigma",
    "×": r"\times",
    "±": r"\pm",
    "·": r"\cdot",
    "−": "-",
    "∝": r"\propto",
    "≤": r"\le",
    "≥": r"\ge",
    "≈": r"\approx",
    "√": r"\surd",
    "→": r"\to",
    "∞": r"\infty",
    "I_zz": "I_{zz}",
    "M0": "M_0",
}

_LEVEL = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹ⁿ₀₁₂₃₄₅₆₇₈₉", "-0123456789n0123456789")
_SIGNS = "".join(sign for sign in _MATH if len(sign) == 1)
_SIGN = rf"\b(?:I_zz|M0)\b|[{_SIGNS}]\u0307?|[⁻⁰-⁹¹²³ⁿ]+|[₀-₉]+"
"""A sign that exists only in mathematics, or a power: "φ̇", "M0", "⁻³"."""


def escape(text: str) -> str:
    r"""Write words of the tool as one line of LaTeX.

    Symbols of quantities and mathematical signs become formulas: "φ̇ψ̇ ∝ M" is
    ``$\dot\varphi\dot\psi \propto M$``.
    """
    return _with_formulas(rf"(?:{_SIGN}|{SYMBOLS.pattern})", text)


def as_typed(text: str) -> str:
    """Write a text from the log as one line of LaTeX that contains no command.

    TeX needs a formula for the signs of mathematics; a single letter stays a letter.
    """
    return _with_formulas(rf"(?:{_SIGN})", text)


def _with_formulas(symbol: str, text: str) -> str:
    """Escape a text; symbols, with what connects them, become formulas."""
    formula = rf"({symbol}(?:[ =/+0-9]*{symbol})*)"
    written = ""
    for i, piece in enumerate(re.split(formula, one_line(text))):
        is_formula = i % 2
        written += f"${re.sub(_SIGN, _sign, piece)}$" if is_formula else _plain(piece)
    # A number stays on the line of its per cent.
    return re.sub(r"(?<=\d) (?=\\%)", "~", written)


def _plain(text: str) -> str:
    """Escape what TeX would execute; two hyphens stay two."""
    escaped = "".join(_SPECIAL.get(letter, letter) for letter in text)
    return re.sub("-(?=-)", "-{}", escaped)


def _sign(match: re.Match[str]) -> str:
    """Write one sign of a formula."""
    sign = match[0].removesuffix("\u0307")
    after = match.string[match.end() : match.end() + 1]
    if sign not in _MATH:
        level = "_" if sign[0] in "₀₁₂₃₄₅₆₇₈₉" else "^"
        return f"{level}{{{sign.translate(_LEVEL)}}}"
    dot = r"\dot" if sign != match[0] else ""
    # The name of a command ends at the next character that is not a letter.
    end = " " if after.isascii() and after.isalpha() else ""
    return f"{dot}{_MATH[sign]}{end}"
