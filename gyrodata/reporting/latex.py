r"""The report as a LaTeX document that a student can edit.

The document is in UTF-8, with values by `siunitx` and tables by `booktabs`.
"""

from __future__ import annotations

import re

from gyrodata.base.errors import shown
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
    join,
)
from gyrodata.results import Analysis

_STYLES = {"code": "texttt", "strong": "textbf", "warn": "textbf"}


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
    return join(sentence, escape, _part)


def _part(part: Part) -> str | None:
    """Write a number or a style; text is left to the caller."""
    if isinstance(part, Number):
        return _quantity(part)
    if isinstance(part, Styled) and part.style in _STYLES:
        return rf"\{_STYLES[part.style]}{{{escape(part.text)}}}"
    return None


def _quantity(number: Number) -> str:
    """Write a number for siunitx; a name or a plain number stays text."""
    if not PLAIN.fullmatch(number.shown[0]):
        return escape(str(number))
    power = number.exponent + number.scale.exponent * number.unit
    times = f" e{power}" if power else ""
    is_interval = number.between != " ± " and len(number.shown) == 2
    ends = number.shown if is_interval else (" +- ".join(number.shown),)
    digits = "".join(f"{{{end}{times}}}" for end in ends)
    if number.unit and number.scale.unit:
        command = r"\qtyrange" if is_interval else r"\qty"
        return f"{command}{digits}{{{number.scale.siunitx}}}"
    plain = digits[1:-1]
    if " " in plain or "e" in plain:
        return rf"\num{digits}"
    if plain.startswith(("-", "+")):
        return f"${plain}$"
    return plain


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
_TOKEN = rf"\b(?:I_zz|M0)\b|[{_SIGNS}]\u0307?|[⁻⁰-⁹¹²³ⁿ]+|[₀-₉]+"
_SYMBOL = rf"(?:{_TOKEN}|{SYMBOLS.pattern})"
_FORMULA = (
    rf"(?:(?<![\w.])[0-9]+(?:[./][0-9]+)? ?)?{_SYMBOL}"
    rf"(?:(?:[ =/+()|]|[0-9]++(?:\.[0-9]++)?+)*{_SYMBOL})*(?:(?: = )?[0-9]+(?:\.[0-9]+)?)?"
)
"""Signs and symbols of quantities, with the numbers and operators between them: 2π I_zz
ψ̇ / (M + M0"""


def escape(text: str) -> str:
    r"""Write text as one line of LaTeX that contains no command of its own.

    Symbols of quantities and mathematical signs become formulas: "φ̇ψ̇ ∝ M" is
    ``$\dot\varphi\dot\psi \propto M$``.
    """
    letters = [" " if letter.isspace() else letter for letter in shown(text)]
    text = "".join(letters)
    done, end = "", 0
    for match in re.finditer(_FORMULA, text):
        formula = match[0]
        behind = text[match.end() : match.end() + 1]
        is_open = formula.count("(") > formula.count(")")
        closes_bracket = behind == ")" and is_open
        closes_bar = behind == "|" and formula.count("|") % 2
        if closes_bracket or closes_bar:
            formula += behind
        done += _plain(text[end : match.start()])
        done += f"${re.sub(_TOKEN, _sign, formula)}$"
        end = match.start() + len(formula)
    done += _plain(text[end:])
    # A number stays on the line of its per cent.
    return re.sub(r"(?<=\d) (?=\\%)", "~", done)


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
