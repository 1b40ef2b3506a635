r"""The report as a LaTeX document that compiles on its own: values with `siunitx`, tables with `booktabs`."""

from __future__ import annotations

import re
import unicodedata
from string import ascii_lowercase, ascii_uppercase

from gyrodata.reporting.content import report
from gyrodata.reporting.tree import (
    SYMBOLS,
    Block,
    Cell,
    Figure,
    Head,
    Interval,
    Number,
    Section,
    Sentence,
    Styled,
    Table,
    Value,
    is_list,
    lines,
    part_text,
)
from gyrodata.reporting.values import Scale, Writing, interval_ends, rounded
from gyrodata.results import Analysis

_PREAMBLE = r"""\documentclass[11pt]{article}
%(encoding)s
\IfFileExists{lmodern.sty}{\usepackage{lmodern}}{}
\usepackage[margin=2cm]{geometry}
\usepackage{array,booktabs,longtable}
\usepackage{float,graphicx}
\floatstyle{plaintop}\restylefloat{table}
\usepackage{siunitx}
\DeclareSIUnit{\rpm}{rpm}
\sisetup{uncertainty-mode = %(uncertainties)s, per-mode = symbol}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
\setlength{\emergencystretch}{3em}
\setlength{\belowcaptionskip}{4pt}
%% A figure is a file of its name beside this one, PDF or PNG.
\newcommand{\gyrofigure}[2]{\begin{figure}[H]\centering
  \IfFileExists{#1.pdf}{\includegraphics[width=0.66\linewidth]{#1.pdf}}{%%
  \IfFileExists{#1.png}{\includegraphics[width=0.66\linewidth]{#1.png}}{%%
  \fbox{\parbox{0.8\linewidth}{\texttt{#1.pdf} or \texttt{#1.png} has to stand beside this file:
  \texttt{gyro analyze LOG -{}-format latex -{}-out FOLDER} writes both.}}}}
  \caption{#2}
\end{figure}}
\begin{document}
"""

CYRILLIC_SETUP = r"""% Cyrillic letters where their fonts are, else Latin ones.
\newif\ifcyrillicfonts
\IfFileExists{t2aenc.def}{\ifdefined\directlua\else\ifdefined\XeTeXversion\else\cyrillicfontstrue\fi\fi}{}
\ifcyrillicfonts
  \usepackage[T2A,T1]{fontenc}
  \DeclareRobustCommand{\cyrillictext}[2]{{\fontencoding{T2A}\selectfont #1}}
\else
  \usepackage[T1]{fontenc}
  \DeclareRobustCommand{\cyrillictext}[2]{#2}
\fi"""
"""What the preamble needs where `escape` has written Cyrillic letters."""

_STYLES = {"code": "texttt", "strong": "textbf", "warn": "textbf"}

_MODES: dict[Writing, str] = {"plain": "separate", "short": "compact-marker"}
"""What siunitx calls the two ways."""

WHOLE = 25
"""A table of more rows than this may break between pages."""

# Ten columns have room on a page with less than the usual blank between them.
_WHOLE_TABLE = r"""\begin{table}[H]\caption{%(caption)s}\centering\small\setlength{\tabcolsep}{4pt}
\begin{tabular}{@{}%(columns)s@{}}
\toprule
%(head)s
\midrule
%(rows)s
\bottomrule
\end{tabular}
\end{table}"""

_LONG_TABLE = r"""{\small\setlength{\tabcolsep}{4pt}
\begin{longtable}{@{}%(columns)s@{}}
\caption{%(caption)s}\\
\toprule
%(head)s
\midrule
\endfirsthead
\toprule
%(head)s
\midrule
\endhead
\bottomrule
\endlastfoot
%(rows)s
\end{longtable}}"""


def latex_report(analysis: Analysis, writing: Writing = "plain") -> str:
    r"""Write the report as a LaTeX document in ASCII.

    Whatever comes from the log is escaped: no ``\input`` in a note is obeyed. One line of the preamble says how
    siunitx sets values with their uncertainties.
    """
    whole = report(analysis)
    blocks = [rf"\section*{{{_sentence(whole.title)}}}", _sentence(whole.read_as)]
    blocks += [rf"\textbf{{{_sentence(doubt)}}}" for doubt in whole.doubts]
    # What is not to be relied on is not set in bold.
    bold = "" if whole.doubts else r"\bfseries\boldmath\sisetup{reset-math-version = false}"
    blocks.append(rf"{{\Large{bold} {_sentence(whole.answer)}\par}}")
    for section in whole.sections:
        blocks += _section(section)
    body = "\n\n".join(blocks)
    encoding = CYRILLIC_SETUP if r"\cyrillictext{" in body else r"\usepackage[T1]{fontenc}"
    preamble = _PREAMBLE % {"encoding": encoding, "uncertainties": _MODES[writing]}
    return f"{preamble}{body}\n\\end{{document}}\n"


def _section(section: Section) -> list[str]:
    command = "sub" * (section.level - 1) + "section*"
    blocks = [rf"\{command}{{{escape(_italic(section.title))}}}"] if section.title else []
    return blocks + [text for block in section.blocks for text in _block(block)]


def _block(block: Block) -> list[str]:
    if isinstance(block, Table):
        return [_table(block)]
    if isinstance(block, Figure):
        return [rf"\gyrofigure{{{block.name}}}{{{escape(_italic(block.caption))}}}"]
    found = [_sentence(line) for line in lines(block)]
    if not is_list(block):
        return found
    items = "\n".join(rf"\item {line}" for line in found)
    return [f"\\begin{{itemize}}\\raggedright\\setlength{{\\itemsep}}{{0pt}}\n{items}\n\\end{{itemize}}"]


def _sentence(sentence: Sentence) -> str:
    """Write a sentence; the text between two values is escaped as a whole."""
    done, text = [], ""
    for part in sentence:
        if isinstance(part, Value | Interval):
            done += [escape(text), _quantity(part)]
            text = ""
        elif isinstance(part, Styled) and part.style in _STYLES:
            done += [escape(text), rf"\{_STYLES[part.style]}{{{escape(part.text)}}}"]
            text = ""
        elif isinstance(part, Number):
            # A minus is not a hyphen.
            text += re.sub(r"^-(?=\d)", "−", part.text)
        else:
            text += _italic(part) if isinstance(part, str) else part_text(part, "plain")
    return "".join([*done, escape(text)])


def _italic(text: str) -> str:
    """Mark the letters that stand for a quantity in a text of the tool."""
    return SYMBOLS.sub(lambda found: found[0].translate(_ITALIC), text)


def _quantity(part: Value | Interval) -> str:
    if isinstance(part, Value):
        number = _number(part, part.scale.exponent)
        return rf"\qty{{{number}}}{{{part.scale.siunitx}}}" if part.scale.unit else rf"\num{{{number}}}"
    power = f"e{part.scale.exponent}" if part.scale.exponent else ""
    low, high = (f"{end}{power}" for end in interval_ends(part.low, part.high, part.scale.size))
    return rf"\qtyrange{{{low}}}{{{high}}}{{{part.scale.siunitx}}}"


def _number(value: Value, exponent: int) -> str:
    """Write a number as siunitx reads it: "4.441 +- 0.023 e-3"."""
    if value.u:
        nominal, spread, own = rounded(value.value, value.u, value.scale.size)
        number, exponent = f"{nominal} +- {spread}", exponent + own
    else:
        number = value.without_u
    return f"{number} e{exponent}" if exponent else number


def _table(table: Table) -> str:
    columns = "".join(_column(head) for head in table.heads)
    head = " & ".join(_head(head) for head in table.heads) + r" \\"
    rows = "\n".join(
        " & ".join(_cell(cell, head) for cell, head in zip(row, table.heads, strict=True)) + r" \\"
        for row in table.rows
    )
    form = _WHOLE_TABLE if len(table.rows) <= WHOLE else _LONG_TABLE
    return form % {"caption": escape(_italic(table.caption)), "columns": columns, "head": head, "rows": rows}


def _column(head: Head) -> str:
    if head.wrap:
        return rf">{{\raggedright\arraybackslash}}p{{{head.wrap:g}\linewidth}}"
    return "r" if head.scale else "l"


def _head(head: Head) -> str:
    """Stack words and unit, so that a column of short numbers stays narrow."""
    words = escape(_italic(head.words))
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
    return _sentence(cell)


# --- any text as LaTeX: plain ASCII, so that every engine reads it, and nothing left that TeX obeys ------------------

_ASCII = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%", "_": r"\_",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': r"\textquotedbl{}", "`": r"\textasciigrave{}",
    # At the start of a row the first two would be options of \\; two of the others in a row become one sign.
    "[": "{[}", "*": "{*}", "-": "-{}", "'": "'{}", ",": ",{}",
}  # fmt: skip

_ITALIC = {ord(letter): 0x1D434 + i for i, letter in enumerate(ascii_uppercase + ascii_lowercase)}
"""Letters as Unicode has them for mathematics, but for an h, which no quantity has here."""

_SYMBOLS = {
    "×": r"\ensuremath{\times}", "±": r"\ensuremath{\pm}", "·": r"\ensuremath{\cdot}", "−": r"\ensuremath{-}",
    "∝": r"\ensuremath{\propto}", "≤": r"\ensuremath{\le}", "≥": r"\ensuremath{\ge}", "≈": r"\ensuremath{\approx}",
    "≠": r"\ensuremath{\ne}", "∞": r"\ensuremath{\infty}", "√": r"\ensuremath{\surd}", "→": r"\ensuremath{\to}",
    "°": r"\textdegree{}", "µ": r"\ensuremath{\mu}", "Δ": r"\ensuremath{\Delta}",
    "–": r"\textendash{}", "—": r"\textemdash{}", "…": r"\dots{}", "•": r"\textbullet{}", "№": "No",
    "‘": r"\textquoteleft{}", "’": r"\textquoteright{}", "“": r"\textquotedblleft{}", "”": r"\textquotedblright{}",
    "„": r"\quotedblbase{}", "«": r"\guillemotleft{}", "»": r"\guillemotright{}",
    "§": r"\S{}", "£": r"\pounds{}", "¡": r"\textexclamdown{}", "¿": r"\textquestiondown{}",
    "ß": r"\ss{}", "æ": r"\ae{}", "Æ": r"\AE{}", "ø": r"\o{}", "Ø": r"\O{}", "œ": r"\oe{}", "Œ": r"\OE{}",
    "ł": r"\l{}", "Ł": r"\L{}", "đ": r"\dj{}", "Đ": r"\DJ{}", "ı": r"\i{}", "þ": r"\th{}", "Þ": r"\TH{}",
    "ð": r"\dh{}", "Ð": r"\DH{}", "\u2044": "/",
    **{raised: rf"\textsuperscript{{{digit}}}" for raised, digit in zip("⁰¹²³⁴⁵⁶⁷⁸⁹ⁿ", "0123456789n", strict=True)},
    "⁻": r"\textsuperscript{\ensuremath{-}}",
    **{chr(code): rf"\ensuremath{{{chr(letter)}}}" for letter, code in _ITALIC.items()},
    **{low: rf"\textsubscript{{{digit}}}" for low, digit in zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True)},
}  # fmt: skip

_TEXT_ACCENTS = {
    "\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u", "\u0307": ".",
    "\u0308": '"', "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0327": "c", "\u0328": "k",
}  # fmt: skip
_MATH_ACCENTS = {"\u0300": "grave", "\u0301": "acute", "\u0304": "bar", "\u0307": "dot", "\u0308": "ddot"}

_GREEK_AS_LATIN = dict(zip("ΑΒΕΖΗΙΚΜΝΟΡΤΧο", "ABEZHIKMNOPTXo", strict=True))
_GREEK_NAMES = {"lamda": "lambda", "final sigma": "varsigma", "epsilon": "varepsilon", "phi": "varphi"}
"""Where LaTeX calls a letter otherwise than Unicode."""

_CYRILLIC = {
    "а": "a", "б": "b", "в": "v", "г": "g", "д": "d", "е": "e", "ж": "zh", "з": "z", "и": "i", "й": "ishrt", "к": "k",
    "л": "l", "м": "m", "н": "n", "о": "o", "п": "p", "р": "r", "с": "s", "т": "t", "у": "u", "ф": "f", "х": "h",
    "ц": "c", "ч": "ch", "ш": "sh", "щ": "shch", "ъ": "hrdsn", "ы": "ery", "ь": "sftsn", "э": "erev", "ю": "yu",
    "я": "ya", "ё": "yo", "є": "ie", "і": "ii", "ї": "yi", "ґ": "gup", "ў": "ushrt",
}  # fmt: skip
"""Names of the letters in LaTeX's encoding T2A, without the ``cyr`` before each; and their sounds, but for these:"""
_SOUNDS = {
    "й": "y",
    "х": "kh",
    "ц": "ts",
    "ъ": "",
    "ы": "y",
    "ь": "",
    "э": "e",
    "є": "ye",
    "і": "i",
    "ґ": "g",
    "ў": "u",
}

_SYMBOL_NAMES = re.compile(r"\bI_zz\b|\bM0\b")
_SET_SYMBOLS = {"I_zz": r"\ensuremath{I_{zz}}", "M0": r"\ensuremath{M_0}"}


def escape(text: str) -> str:
    r"""Write text as one line of ASCII that LaTeX prints and obeys nothing in.

    Latin letters with accents, Greek and Cyrillic ones (`CYRILLIC_SETUP` has to be in the preamble for these) and
    usual signs are printed; any other character is printed as its code, "[U+4E2D]". I_zz and M0 are set as formulas.
    """
    done, end = [], 0
    for symbol in _SYMBOL_NAMES.finditer(text):
        done += [_plain(text[end : symbol.start()]), _SET_SYMBOLS[symbol[0]]]
        end = symbol.end()
    # No line begins with the sign of the number that ends the last one.
    return re.sub(r"(?<=\d) (?=\\%)", r"\\nobreakspace{}", "".join([*done, _plain(text[end:])]))


def _plain(text: str) -> str:
    # Composed first: a Cyrillic й is one letter, though it can be written with an accent.
    text = unicodedata.normalize("NFC", text)
    done, i = [], 0
    while i < len(text):
        accents = i + 1
        while accents < len(text) and unicodedata.combining(text[accents]):
            accents += 1
        done.append(_character(text[i], text[i + 1 : accents]))
        i = accents
    return _join_cyrillic("".join(done))


def _character(character: str, accents: str = "") -> str:
    if accents:
        return _accented(character, accents)
    if character.isascii() and character.isprintable():
        return _ASCII.get(character, character)
    if character in _SYMBOLS:
        return _SYMBOLS[character]
    if character in _GREEK_AS_LATIN:
        return _GREEK_AS_LATIN[character]
    if _is_greek(character):
        return rf"\ensuremath{{{_greek(character)}}}"
    if character.lower() in _CYRILLIC:
        return _cyrillic(character)
    return _by_parts(character)


def _by_parts(character: str) -> str:
    """Take a character apart, replace it by a blank or nothing, or print its code."""
    category = unicodedata.category(character)
    if category in ("Cc", "Zs", "Zl", "Zp"):
        return " "
    if category == "Cf":
        return ""
    parts = unicodedata.normalize("NFD", character)
    if len(parts) > 1:
        return _accented(parts[0], parts[1:])
    alike = unicodedata.normalize("NFKD", character)
    return _plain(alike) if alike != character else f"{{[}}U+{ord(character):04X}]"


def _accented(character: str, accents: str) -> str:
    first, rest = accents[0], accents[1:]
    codes = "".join(map(_by_parts, rest))
    if _is_greek(character) and first in _MATH_ACCENTS:
        return rf"\ensuremath{{\{_MATH_ACCENTS[first]}{{{_greek(character)}}}}}" + codes
    if character.isascii() and character.isalpha() and first in _TEXT_ACCENTS:
        return rf"\{_TEXT_ACCENTS[first]}{{{character}}}" + codes
    return _character(character) + "".join(map(_by_parts, accents))


def _is_greek(character: str) -> bool:
    """Tell whether it is one of the letters of the alphabet, without an accent."""
    return ("Α" <= character <= "Ω" or "α" <= character <= "ω") and unicodedata.category(character) != "Cn"


def _greek(letter: str) -> str:
    if letter in _GREEK_AS_LATIN:
        return _GREEK_AS_LATIN[letter]
    size, name = unicodedata.name(letter).removeprefix("GREEK ").lower().split(" letter ")
    name = _GREEK_NAMES.get(name, name)
    return f"\\{name}" if size == "small" else f"\\{name.removeprefix('var').capitalize()}"


def _cyrillic(letter: str) -> str:
    name = _CYRILLIC[letter.lower()]
    sound = _SOUNDS.get(letter.lower(), name)
    if letter.islower():
        return rf"\cyrillictext{{\cyr{name}}}{{{sound}}}"
    return rf"\cyrillictext{{\CYR{name.upper()}}}{{{sound.capitalize()}}}"


_WORD = re.compile(r"(?:\\cyrillictext\{[^}]*\}\{[^}]*\}){2,}")
_LETTER = re.compile(r"\\cyrillictext\{([^}]*)\}\{([^}]*)\}")


def _join_cyrillic(text: str) -> str:
    """Make one command of the letters of a word: kerning is lost between two."""

    def joined(word: re.Match[str]) -> str:
        letters, sounds = zip(*_LETTER.findall(word[0]), strict=True)
        return rf"\cyrillictext{{{''.join(letters)}}}{{{''.join(sounds)}}}"

    return _WORD.sub(joined, text)
