r"""The report as a LaTeX document that a student can edit.

The document is in UTF-8, with values by `siunitx` and tables by `booktabs`.
"""

from __future__ import annotations

import re
from pathlib import Path

from gyrodata.base.errors import shown
from gyrodata.reporting.content import report
from gyrodata.reporting.data import templates
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
    room = templates(Path(__file__).parent, **signs)
    room.filters |= {
        "sentence": lambda sentence: _sentence(sentence).replace(answer, r"\Izz{}"),
        "text": escape,
        "head": _head,
        "column_type": _column_type,
        "row": _row,
    }
    document = room.get_template("report.tex.jinja").render(whole=whole, answer=answer)
    return re.sub(r"\n{3,}", "\n\n", document).strip() + "\n"


def _row(row: str) -> str:
    r"""Protect a row that TeX would read as an option of the ``\\`` before it."""
    return f"{{}}{row}" if row.startswith(("[", "*")) else row


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
    power = number.exponent + number.scale.exponent * number.unit
    digits = [f"{text} e{power}" if power else text for text in number.shown]
    if number.between == " ± " and len(digits) == 2:
        digits = [" +- ".join(number.shown) + (f" e{power}" if power else "")]
    if not re.fullmatch(r"[-+]?[0-9.]+(e[-+]?[0-9]+)?", number.shown[0]):
        return escape(str(number))
    if number.unit and number.scale.unit:
        command = r"\qtyrange" if len(digits) == 2 else r"\qty"
        return (
            command
            + "".join(f"{{{part}}}" for part in digits)
            + f"{{{number.scale.siunitx}}}"
        )
    if re.search("[ e]", digits[0]):
        return rf"\num{{{digits[0]}}}"
    return f"${digits[0]}$" if digits[0][0] in "-+" else digits[0]


def _head(head: Head) -> str:
    """Write the unit below the words: a column of numbers stays narrow."""
    if head.scale is None or not head.scale.unit:
        return escape(head.words)
    power = rf"\num{{e{head.scale.exponent}}}\," if head.scale.exponent else ""
    return rf"\shortstack[r]{{{escape(head.words)}\\{{[}}{power}\unit{{{head.scale.siunitx}}}]}}"


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
_TOKEN = (
    rf"\b(?:I_zz|M0)\b|[{''.join(one for one in _MATH if len(one) == 1)}]\u0307?"
    rf"|[⁻⁰-⁹¹²³ⁿ]+|[₀-₉]+"
)
_FORMULA = (
    rf"(?:(?<![\w.])[0-9]+(?:[./][0-9]+)? ?)?(?:{_TOKEN}|{SYMBOLS.pattern})"
    rf"(?:(?:[ =/+()|]|[0-9]++(?:\.[0-9]++)?+)*(?:{_TOKEN}|{SYMBOLS.pattern}))*(?:(?: "
    rf"= )?[0-9]+(?:\.[0-9]+)?)?"
)
"""Signs and symbols of quantities, with the numbers and operators between them: 2π I_zz
ψ̇ / (M + M0"""


def escape(text: str) -> str:
    r"""Write text as one line of LaTeX that contains no command of its own.

    Symbols of quantities and mathematical signs become formulas: "φ̇ψ̇ ∝ M" is
    ``$\dot\varphi\dot\psi \propto M$``.
    """
    text = "".join(" " if letter.isspace() else letter for letter in shown(text))
    done, end = "", 0
    for match in re.finditer(_FORMULA, text):
        formula = match[0]
        behind = text[match.end() : match.end() + 1]
        is_open = {
            ")": formula.count("(") > formula.count(")"),
            "|": formula.count("|") % 2,
        }
        formula += behind if is_open.get(behind) else ""
        done += f"{_plain(text[end : match.start()])}${re.sub(_TOKEN, _sign, formula)}$"
        end = match.start() + len(formula)
    # A number stays on the line of its per cent.
    return re.sub(r"(?<=\d) (?=\\%)", "~", done + _plain(text[end:]))


def _plain(text: str) -> str:
    """Escape what TeX would execute; two hyphens stay two."""
    return (
        "".join(_SPECIAL.get(letter, letter) for letter in text)
        .replace("--", "-{}-")
        .replace("--", "-{}-")
    )


def _sign(match: re.Match[str]) -> str:
    """Write one sign of a formula."""
    sign = match[0].removesuffix("\u0307")
    after = match.string[match.end() : match.end() + 1]
    if sign not in _MATH:
        return f"{'_' if sign[0] in '₀₁₂₃₄₅₆₇₈₉' else '^'}{{{sign.translate(_LEVEL)}}}"
    written = (r"\dot" if sign != match[0] else "") + _MATH[sign]
    # The name of a command ends at the next character that is not a letter.
    return written + " " * (after.isascii() and after.isalpha())
