r"""The report as a LaTeX document that compiles on its own: values with `siunitx`, tables with `booktabs`."""

from __future__ import annotations

import re

from gyrodata.reporting.content import Cell, Head, Interval, Section, Sentence, Table, Value, answer, sections, title
from gyrodata.reporting.tex_text import CYRILLIC_SETUP, escape
from gyrodata.reporting.values import Scale, Writing, interval_ends, reading_text, rounded, uncertainty_text
from gyrodata.results import Analysis

_PREAMBLE = r"""\documentclass[11pt]{article}
%(encoding)s
\IfFileExists{lmodern.sty}{\usepackage{lmodern}}{}
\usepackage[margin=2cm]{geometry}
\usepackage{array,booktabs,longtable}
\usepackage{siunitx}
\DeclareSIUnit{\rpm}{rpm}
\sisetup{uncertainty-mode = %(uncertainties)s, per-mode = symbol}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
\setlength{\emergencystretch}{3em}
\begin{document}
"""

_MODES: dict[Writing, str] = {"plain": "separate", "short": "compact-marker"}
"""What siunitx calls the two ways."""

WHOLE = 25
"""A table of more rows than this may break between pages."""

# Ten columns have room on a page with less than the usual blank between them.
_WHOLE_TABLE = r"""{\centering\small\setlength{\tabcolsep}{4pt}
\begin{tabular}{@{}%(columns)s@{}}
\toprule
%(head)s
\midrule
%(rows)s
\bottomrule
\end{tabular}\par}"""

_LONG_TABLE = r"""{\small\setlength{\tabcolsep}{4pt}
\begin{longtable}{@{}%(columns)s@{}}
\toprule
%(head)s
\midrule
\endhead
\bottomrule
\endlastfoot
%(rows)s
\end{longtable}}"""


def latex_report(analysis: Analysis, writing: Writing = "plain") -> str:
    r"""Write the report as a LaTeX document.

    Parameters
    ----------
    analysis : Analysis
        The result.
    writing : {"plain", "short"}
        Whether siunitx sets "4.441 ± 0.023" or "4.441(23)"; one line of the preamble says which.

    Returns
    -------
    str
        ASCII. Whatever comes from the log is escaped: no ``\input`` in a note is obeyed.
    """
    blocks = [rf"\section*{{{escape(title(analysis))}}}", rf"{{\Large\bfseries {_sentence(answer(analysis))}\par}}"]
    for section in sections(analysis):
        blocks += _section(section)
    body = "\n\n".join(blocks)
    encoding = CYRILLIC_SETUP if r"\cyrillictext{" in body else r"\usepackage[T1]{fontenc}"
    preamble = _PREAMBLE % {"encoding": encoding, "uncertainties": _MODES[writing]}
    return f"{preamble}{body}\n\\end{{document}}\n"


def _section(section: Section) -> list[str]:
    blocks = [rf"\subsection*{{{escape(section.title)}}}"] if section.title else []
    blocks += [_sentence(sentence) for sentence in section.sentences]
    if section.table:
        blocks.append(_table(section.table))
    if section.items:
        items = "\n".join(rf"\item {_sentence(item)}" for item in section.items)
        blocks.append(f"\\begin{{itemize}}\\setlength{{\\itemsep}}{{0pt}}\n{items}\n\\end{{itemize}}")
    return blocks


def _sentence(sentence: Sentence) -> str:
    return "".join(_part(part) for part in sentence)


def _part(part: str | Value | Interval) -> str:
    if isinstance(part, Value):
        number = _number(part, part.scale.exponent)
        return rf"\qty{{{number}}}{{{part.scale.siunitx}}}" if part.scale.unit else rf"\num{{{number}}}"
    if isinstance(part, Interval):
        power = f"e{part.scale.exponent}" if part.scale.exponent else ""
        low, high = (f"{end}{power}" for end in interval_ends(part.low, part.high, part.scale.size))
        return rf"\qtyrange{{{low}}}{{{high}}}{{{part.scale.siunitx}}}"
    return escape(part)


def _number(value: Value, exponent: int) -> str:
    """Write a number as siunitx reads it: "4.441 +- 0.023 e-3"."""
    if value.u:
        nominal, spread, own = rounded(value.value, value.u, value.scale.size)
        number, exponent = f"{nominal} +- {spread}", exponent + own
    else:
        number = (uncertainty_text if value.is_u else reading_text)(value.value, value.scale.size)
    return f"{number} e{exponent}" if exponent else number


def _table(table: Table) -> str:
    columns = "".join(_column(head) for head in table.heads)
    head = " & ".join(_head(head) for head in table.heads) + r" \\"
    rows = "\n".join(
        " & ".join(_cell(cell, head) for cell, head in zip(row, table.heads, strict=True)) + r" \\"
        for row in table.rows
    )
    form = _WHOLE_TABLE if len(table.rows) <= WHOLE else _LONG_TABLE
    return form % {"columns": columns, "head": head, "rows": rows}


def _column(head: Head) -> str:
    if head.wrap:
        return rf">{{\raggedright\arraybackslash}}p{{{head.wrap:g}\linewidth}}"
    return "r" if head.scale else "l"


def _head(head: Head) -> str:
    """Stack words and unit, so that a column of short numbers stays narrow."""
    words = escape(head.words)
    if head.scale is None or not str(head.scale):
        return words
    return rf"\shortstack[r]{{{words}\\{{[}}{_unit(head.scale)}]}}"


def _unit(scale: Scale) -> str:
    power = rf"\num{{e{scale.exponent}}}\," if scale.exponent else ""
    return rf"{power}\unit{{{scale.siunitx}}}"


def _cell(cell: Cell, head: Head) -> str:
    if cell is None:
        return r"\textendash{}" if head.scale else ""
    if isinstance(cell, Value):
        return rf"\num{{{_number(cell, 0)}}}"
    # A minus before a number is not a hyphen.
    return re.sub(r"(?<!\w)-\{\}(?=\d)", r"\\ensuremath{-}", escape(cell)) if head.scale else escape(cell)
