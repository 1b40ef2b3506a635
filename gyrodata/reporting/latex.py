r"""The report as a LaTeX document that a student can edit: UTF-8, values by `siunitx`, tables by `booktabs`."""

from __future__ import annotations

import re
import unicodedata
from string import ascii_lowercase, ascii_uppercase

from gyrodata.reporting import content, tree, values
from gyrodata.results import Analysis

_PREAMBLE = r"""% Compile this file with pdflatex. Use lualatex if a name contains letters that are not Latin.
\documentclass[11pt]{article}
\usepackage{iftex}
\ifpdftex\usepackage[T1]{fontenc}\usepackage{lmodern}
\else\usepackage{fontspec}\IfFontExistsTF{CMU Serif}{\setmainfont{CMU Serif}}{}\fi
\usepackage[margin=2cm]{geometry}
\usepackage{array,booktabs,float,graphicx,longtable,siunitx}
\DeclareSIUnit{\rpm}{rpm}
\sisetup{uncertainty-mode = separate, per-mode = symbol}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
\setlength{\emergencystretch}{3em}
\setlength{\tabcolsep}{4pt}
\graphicspath{{./}}
\newcommand{\Izz}{ANSWER}

\begin{document}
"""

_FIGURE = r"""\begin{figure}[H]
\centering
\includegraphics[width=0.7\linewidth]{%s}
\caption{%s}
\end{figure}"""

_TABLE = r"""{\small
\begin{longtable}{@{}%(columns)s@{}}
\caption{%(caption)s}\\
\toprule
%(head)s \\
\midrule
\endhead
\bottomrule
\endlastfoot
%(rows)s
\end{longtable}}"""

_STYLES = {"code": "texttt", "strong": "textbf", "warn": "textbf"}


def latex_report(analysis: Analysis) -> str:
    r"""Write the report as a LaTeX document.

    The macro ``\Izz`` contains the answer. Text from the log is escaped: TeX executes nothing in it.
    """
    whole = content.report(analysis)
    answer = next((_quantity(part) for part in whole.answer if isinstance(part, tree.Value)), "")
    blocks = [rf"\section*{{{_sentence(whole.title)}}}", _sentence(whole.read_as)]
    blocks += [rf"\textbf{{{_sentence(doubt)}}}" for doubt in whole.doubts]
    # An answer that the log contradicts is not set in bold.
    bold = "" if whole.doubts else r"\bfseries\boldmath\sisetup{reset-math-version = false}"
    said = _sentence(whole.answer)
    said = said.replace(answer, r"\Izz{}", 1) if answer else said
    blocks.append(rf"{{\Large{bold} {said}\par}}")
    for section in whole.sections:
        if section.title:
            blocks.append(rf"\{'sub' * (section.level - 1)}section*{{{escape(_italic(section.title))}}}")
        blocks += [text for block in section.blocks for text in _block(block)]
    return "\n\n".join([_PREAMBLE.replace("ANSWER", answer) + blocks[0], *blocks[1:], "\\end{document}\n"])


def _block(block: tree.Block) -> list[str]:
    """Write a block as paragraphs, a list, a table or a figure."""
    if isinstance(block, tree.Figure):
        return [_FIGURE % (block.name, escape(_italic(block.caption)))]
    if isinstance(block, tree.Table):
        rows = (
            " & ".join(_cell(cell, head) for cell, head in zip(row, block.heads, strict=True)) for row in block.rows
        )
        columns = (
            rf">{{\raggedright\arraybackslash}}p{{{head.wrap:g}\linewidth}}"
            if head.wrap
            else "r"
            if head.scale
            else "l"
            for head in block.heads
        )
        parts = {
            "columns": "".join(columns),
            "caption": escape(_italic(block.caption)),
            "head": " & ".join(map(_head, block.heads)),
            # After \\ TeX would take a [ or a * for an option.
            "rows": "\n".join(rf"{'{}' * row.startswith(('[', '*'))}{row} \\" for row in rows),
        }
        return [_TABLE % parts]
    found = [_sentence(line) for line in tree.lines(block)]
    if not tree.is_list(block):
        return found
    items = "\n".join(rf"\item {line}" for line in found)
    return [f"\\begin{{itemize}}\\raggedright\n{items}\n\\end{{itemize}}"]


def _sentence(sentence: tree.Sentence) -> str:
    """Write a sentence; the text between two values is escaped as a whole."""
    done, text = [], ""
    for part in sentence:
        if isinstance(part, tree.Value | tree.Interval):
            done += [escape(text), _quantity(part)]
            text = ""
        elif isinstance(part, tree.Styled) and part.style in _STYLES:
            done += [escape(text), rf"\{_STYLES[part.style]}{{{escape(part.text)}}}"]
            text = ""
        elif isinstance(part, tree.Number):
            # A minus is not a hyphen.
            text += re.sub(r"^-(?=\d)", "−", part.text)
        else:
            text += _italic(part) if isinstance(part, str) else tree.part_text(part)
    return "".join([*done, escape(text)])


def _quantity(part: tree.Value | tree.Interval) -> str:
    if isinstance(part, tree.Value):
        number = _number(part, part.scale.exponent)
        return rf"\qty{{{number}}}{{{part.scale.siunitx}}}" if part.scale.unit else rf"\num{{{number}}}"
    power = f"e{part.scale.exponent}" if part.scale.exponent else ""
    low, high = (f"{end}{power}" for end in values.interval_ends(part.low, part.high, part.scale.size))
    return rf"\qtyrange{{{low}}}{{{high}}}{{{part.scale.siunitx}}}"


def _number(value: tree.Value, exponent: int) -> str:
    """Write a number as siunitx reads it: "4.441 +- 0.023 e-3"."""
    number = value.without_u
    if value.u:
        nominal, spread, own = values.rounded(value.value, value.u, value.scale.size)
        number, exponent = f"{nominal} +- {spread}", exponent + own
    return f"{number} e{exponent}" if exponent else number


def _head(head: tree.Head) -> str:
    """Write the unit below the words, so that a column of short numbers stays narrow."""
    words = escape(_italic(head.words))
    if head.scale is None or not str(head.scale):
        return words
    power = rf"\num{{e{head.scale.exponent}}}\," if head.scale.exponent else ""
    return rf"\shortstack[r]{{{words}\\{{[}}{power}\unit{{{head.scale.siunitx}}}]}}"


def _cell(cell: tree.Cell, head: tree.Head) -> str:
    if cell is None:
        return "–" if head.scale else ""
    return rf"\num{{{_number(cell, 0)}}}" if isinstance(cell, tree.Value) else _sentence(cell)


# --- text from the tool and from the log ------------------------------------------------------------------------------

_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%", "_": r"\_",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
}  # fmt: skip

_ITALIC = {ord(letter): 0x1D434 + i for i, letter in enumerate(ascii_uppercase + ascii_lowercase)}
"""Letters as Unicode has them for mathematics; a quantity of the tool is never called h, whose code is another."""

_MATH = {
    "φ": r"\varphi", "ψ": r"\psi", "θ": r"\theta", "τ": r"\tau", "π": r"\pi", "χ": r"\chi", "σ": r"\sigma",
    "ω": r"\omega", "Ω": r"\Omega", "Δ": r"\Delta", "Σ": r"\Sigma", "×": r"\times", "±": r"\pm", "·": r"\cdot",
    "−": "-", "∝": r"\propto", "≤": r"\le", "≥": r"\ge", "≈": r"\approx", "√": r"\surd", "→": r"\to", "∞": r"\infty",
    "I_zz": "I_{zz}", "M0": "M_0", **{chr(code): chr(letter) for letter, code in _ITALIC.items()},
}  # fmt: skip

_LEVEL = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹ⁿ₀₁₂₃₄₅₆₇₈₉", "-0123456789n0123456789")
_TOKEN = re.compile(
    rf"(\bI_zz\b|\bM0\b|[{''.join(one for one in _MATH if len(one) == 1)}])(\u0307?)|([⁻⁰-⁹¹²³ⁿ]+)|([₀-₉]+)"
)
_FORMULA = re.compile(f"(?:{_TOKEN.pattern})+")


def _italic(text: str) -> str:
    """Mark the letters that mean a quantity in a text of the tool."""
    return tree.SYMBOLS.sub(lambda found: found[0].translate(_ITALIC), text)


def escape(text: str) -> str:
    r"""Write text as one line of LaTeX that contains no command of its own.

    Symbols of quantities and mathematical signs become formulas: "φ̇ψ̇ ∝ M" is ``$\dot\varphi\dot\psi$ ...``.
    """
    text = unicodedata.normalize("NFC", text)
    kinds = ((one, unicodedata.category(one)) for one in text)
    text = "".join(" " if kind in ("Cc", "Zl", "Zp", "Zs") else one for one, kind in kinds if kind not in _UNSEEN)
    done, end = [], 0
    for found in _FORMULA.finditer(text):
        done += [_plain(text[end : found.start()]), f"${_formula(found[0])}$"]
        end = found.end()
    # A number stays on the line of its per cent.
    return re.sub(r"(?<=\d) (?=\\%)", "~", "".join([*done, _plain(text[end:])]))


_UNSEEN = ("Cf", "Cs", "Co", "Cn")


def _plain(text: str) -> str:
    """Escape what TeX would execute; two hyphens stay two."""
    return "".join(_SPECIAL.get(one, one) for one in text).replace("--", "-{}-").replace("--", "-{}-")


def _formula(text: str) -> str:
    """Write signs as the inside of a formula."""
    done = ""
    for sign, dot, raised, lowered in _TOKEN.findall(text):
        if sign:
            part = (r"\dot" if dot else "") + _MATH[sign]
        else:
            part = f"{'^' if raised else '_'}{{{(raised or lowered).translate(_LEVEL)}}}"
        # The name of a command ends where no letter follows.
        between = " " if re.search(r"\\[a-z]+$", done, re.IGNORECASE) and part[0].isalpha() else ""
        done += between + part
    return done
