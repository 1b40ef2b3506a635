"""Find the values in a text that may be the reported I_zz.

The lines become sentences, without markup and with the rows of tables as people write
lines. A number in a sentence is a quantity if it has a unit of I_zz, or if the name of
I_zz is directly in front of it. It becomes a candidate unless the words around it say
that it is another value, such as one of theory.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.grading.submissions.documents import (
    LONGEST_LINE,
    MOST_LINES,
    PLAIN,
    SAYS,
    Document,
)
from gyrodata.grading.submissions.visible import HAS_UNIT
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import Reported, read_reported
from gyrodata.readings.names import UNSURE_WORDS, name_roles, squeezed_words

MOST_BELOW = 7  # lines in which an uncertainty may follow
_MOST_VALUES = 100
_LONGEST_SENTENCE, _LONGEST_VALUE = 1000, 120


class Rank(NamedTuple):
    """How likely a value is the answer; the first difference decides."""

    is_named: bool  # words in front name I_zz or a result
    has_u: bool
    is_result: bool  # words in front name a result, and no other number
    version: int = 0  # by `version_in`


class Candidate(Struct, frozen=True):
    """A quantity that may be the answer."""

    rank: Rank
    place: str
    read: Reported
    doubt: bool = False  # whether a person may not see it
    compared: bool = False  # no answer, by a word of a comparison alone ("close to")
    has_second_u: bool = False  # whether a total uncertainty may follow its u
    of_gyro: bool = False  # whether it is in a report that gyro analyze wrote

    @property
    def file(self) -> str:
        """The name of the file."""
        return self.place.rpartition(", line ")[0]


class Text(Struct, frozen=True):
    """The values in a document, and why a part of it is not read."""

    values: Sequence[Candidate]
    cut: str = ""  # question about a value that may be in a part that is not read


def find_candidates(document: Document) -> Text:
    """Find the quantities of a document that may be the answer.

    >>> lines = ["By theory, I_zz = 4.5 g m^2.", "We find I_zz = 4.4 g m^2."]
    >>> [value] = find_candidates(Document("report.txt", lines)).values
    >>> value.read.value, value.place, value.rank.is_named, value.rank.has_u
    (0.0044, 'report.txt, line 2', True, False)

    Of a report of gyro, it is the first one; the others are in its tables.
    """
    text = _read_text(document)
    if not _is_report_of_gyro(document):
        return text
    first = [replace(value, of_gyro=True, doubt=False) for value in text.values[:1]]
    return Text(first)


def _read_text(document: Document) -> Text:
    """Find all quantities that may be the answer, and say what is not read."""
    end = _end_of_read(document.lines)
    sentences = _sentences(_keys_as_prose(document, document.lines[:end]))
    short = [(line, text) for line, text in sentences if len(text) <= _LONGEST_SENTENCE]
    values = list(islice(_candidates(document, short), _MOST_VALUES + 1))
    unread = [
        *document.lines[end:],
        *(line[LONGEST_LINE:] for line in document.lines[:end]),
        *(text for _, text in sentences if len(text) > _LONGEST_SENTENCE),
    ]
    if len(values) > _MOST_VALUES or any(map(HAS_UNIT.search, unread)):
        why = "is too long"
    elif any(map(HAS_UNIT.search, document.unseen)):
        why = "contains text that nobody sees"
    else:
        return Text(values)
    cut = f"{document.name} {why}: a part of it is not read"
    cut += ", and may have another answer"
    return Text(values[:_MOST_VALUES], cut)


_TOP_OF_REPORT = 20
"""Lines in which a report of gyro has its title and its first run."""


def _is_report_of_gyro(document: Document) -> bool:
    """Return whether a text is a report of ``gyro analyze``, also printed."""
    filled = filter(None, map(str.strip, document.lines))
    beginning = "\n".join(islice(filled, _TOP_OF_REPORT))
    title = re.search(r"^[# ]*Gyroscope lab (?:report|worksheet): ", beginning, re.M)
    return bool(title) and "Read as: run" in beginning


def _end_of_read(lines: Sequence[str]) -> int:
    """Return the number of lines that are read, of which blank ones do not count."""
    filled = [at for at, line in enumerate(lines, 1) if line.strip()]
    if len(filled) <= MOST_LINES:
        return len(lines)
    return filled[MOST_LINES - 1]


# --- lines become sentences ---


def _sentences(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Split lines into sentences without markup, each with the number of its line."""
    sentences = []
    plain = [line[:LONGEST_LINE] for line in lines]
    for pattern, text in PLAIN:
        plain = [line and re.sub(pattern, text, line) for line in plain]
    ends = r"(?<=[!?;])\s+(?=[^\W\d])|(?<=\.)\s+(?=[A-ZÀ-ÝΘ])"
    for number, line in enumerate(_rows_as_prose(plain), 1):
        sentences += [(number, sentence) for sentence in re.split(ends, line)]
    return [(number, sentence) for number, sentence in sentences if sentence.strip()]


def _rows_as_prose(lines: Sequence[str]) -> Iterator[str]:
    """Write the rows of tables as lines of text, below the titles of each table."""
    titles = list[str]()
    for line in lines:
        cells = [cell.strip(" *") for cell in re.sub(_OUTER_BARS, "", line).split("|")]
        is_table = len(cells) > 1
        has_number = any(map(_is_number, cells))
        if not has_number and not set(line) <= set("-: |"):
            titles = cells * is_table
        if has_number and is_table:
            line = _row_as_prose(
                _with_title_of_u(titles, cells), _unit_behind_number(cells)
            )
        yield line


def _keys_as_prose(document: Document, lines: Sequence[str]) -> Sequence[str]:
    """Write the keys of TOML for an uncertainty and a unit behind their value.

    Each value keeps its line. Other documents stay as they are.
    """
    if ".toml" not in document.name.lower():
        return lines
    prose = [""] * len(lines)
    table = name = ""
    at = 0  # line of the last value
    for number, part in _parts_of(lines):
        key, _, value = (text.strip() for text in part.partition("="))
        sign = _sign_of(key, name, prose[at])
        if not value:
            table = key.strip("[] ").rpartition(".")[2] or table
            # The keys of another table belong to no value above it.
            name *= not key.startswith("[")
            prose[number] += part
        elif sign is None:
            name = key
            at = number
            is_value = re.fullmatch(SAYS["value"], key)
            prose[at] += f"{table} = {value}" if is_value else part
        else:
            whole = prose[at].partition(" #")[0]
            more = value.partition(" #")[0]
            prose[at] = f"{whole} {sign} {more}"
    return prose


def _parts_of(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines, and the parts of those with an inline table, with numbers."""
    for number, line in enumerate(lines):
        parts = re.split("[{},]", line, maxsplit=9) if "{" in line else [line]
        yield from ((number, part) for part in parts)


def _sign_of(key: str, name: str, line: str) -> str | None:
    """Return the sign between the value `name` and that of a key that belongs to it.

    None if the key does not belong to it: it has another name, or its line is long.
    """
    is_other = "_" in key and f"_{name}_" not in f"_{key}_"
    if not name or is_other or len(line) > _LONGEST_SENTENCE:
        return None
    if any(re.fullmatch(SAYS["unit_key"], word) for word in key.split("_")):
        return ""
    return "±" if _is_unsure(key) else None


def _with_title_of_u(titles: Sequence[str], cells: Sequence[str]) -> Sequence[str]:
    """Add a title to the second of two numbers if it may be the uncertainty.

    A row of runs begins with a number.
    """
    numbers = [at for at, cell in enumerate(cells) if _is_number(cell)]
    if len(numbers) != 2 or 0 in numbers or any(map(_is_unsure, titles)):
        return titles
    if not _may_be_u(*[cells[at] for at in numbers]):
        return titles
    missing = [""] * (len(cells) - len(titles))
    whole = [*missing, *titles]
    whole[numbers[1]] = f"± {whole[numbers[1]]}"
    return whole


def _unit_behind_number(cells: Sequence[str]) -> Sequence[str]:
    """Move the unit of a row, as in "g m² | I_zz | 4.40", behind the first number."""
    value = next(filter(_is_number, cells))
    at = cells.index(value)
    unit = next((cell for cell in cells[:at] if "inertia" in kinds_of(cell)), None)
    if unit is None or re.search(_UNIT, value):
        return cells
    names = ["" if cell == unit else cell for cell in cells[:at]]
    return [*names, f"{value} {unit}", *cells[at + 1 :]]


def _may_be_u(value: str, number: str) -> bool:
    """Return whether a number may be the uncertainty of a value, by its size."""
    both = read_reported("inertia", f"{value} ± {number} kg m^2")
    most = 0.2 * abs(both.value or 0)
    return both.fault is None and 0 < (both.u or 0) < most


def _row_as_prose(titles: Sequence[str], cells: Sequence[str]) -> str:
    """Write the cells with the sign ± and with units."""
    # Titles are aligned on the right: the names of rows may have none.
    missing = [""] * (len(cells) - len(titles))
    line = ""
    for title, cell in zip([*missing, *titles], cells, strict=False):
        text = _with_unit(title, cell)
        if line and _is_number(cell) and _is_unsure(title):
            line += f" ± {text}{' %' * ('%' in title)}"
        elif _is_blank_or_unit(text) and not _is_number(cell):
            line += f" {text}"
        elif re.search(SAYS["other"], title):
            line += f" | {title}: {text}"
        else:
            line += f" | {text}"
    return line


def _with_unit(title: str, cell: str) -> str:
    """Write the unit of a title behind a number that has none."""
    if not _is_number(cell) or re.search(_UNIT, cell):
        return cell
    return f"{cell} {_unit_behind(title)}".rstrip()


def _is_blank_or_unit(cell: str) -> bool:
    if not cell or kinds_of(cell):
        return True
    return bool(_unit_behind(f"/{cell}"))


def _is_number(text: str) -> bool:
    return re.match(rf"\s*+[-+(]*+(?!{_POWER})[.,]?\d", text) is not None


def _is_unsure(text: str) -> bool:
    """Return whether words contain one of an uncertainty."""
    if squeezed_words(text) & UNSURE_WORDS:
        return True
    return re.search(SAYS["unsure"], text) is not None


def _unit_behind(text: str) -> str:
    """Return the unit of I_zz, or the power of ten, in a name or title.

    It is in brackets, as in "Value (10⁻³ kg m²)".
    """
    match = re.search(_UNIT_AT_END, text)
    if match is None:
        return ""
    power, unit = match.groups("")
    is_power = power and not unit
    if not is_power and "inertia" not in kinds_of(unit):
        return ""
    return power.lstrip(" x×·*") + unit


# --- numbers with a unit or a name become quantities ---

_UNIT = r"(?i)g[\s·*.⋅/-]{0,3}[cm]?m|n[\s·*.⋅]*m"
_OTHER_UNIT = (
    r"[\d.,()±+/−⁻⁰-⁹\s×x*·^eE-]+?[kmc]{0,2}[gN](?:[\s·*⋅./]*(?:[ckm]?m|s|rad)(?:\^"
    r"|\*\*)?[\d²³]?){1,3}"
)
_POWER = r"[x×·*\s]*10\s?\^?\s?[-−⁻]\s?[\d⁰¹²³⁴-⁹]+\s*"
_UNIT_AT_END = rf"(?:[\[(]|\bin\b|/)\s*({_POWER})?([^\[\]()|/]*)[\])]?[\s*_]*$"
_START = r"(?<![\w.,^(+\-−±/*×·])(?<![/*×·]\s)\(?[-+−]?\(?(?:\d|[.,]\d)"
_CUT = r"[,;.|]?\s+|(?<![.,;|])[.,;|]*$"
_OTHER_VALUE = rf"[\[(][^()\[\]]{{1,60}}\d[^()\[\]]{{0,20}}(?:{_UNIT[4:]})"
"""A bracket with a value to compare: "(expected 4.5 g m^2)"."""
_OUTER_BARS = r"^\|(?:[\s|]+$)?|(?<![\s|])[\s|]+$"
_COUNT = r"(?<![\w.,])\d{1,2}(?=\s(?!percent|per cent|Prozent)(?i:[^\W\d]{3}|is\b|es\b|we\b))"
_TWO_NUMBERS = rf"(?<![\w.,^])\d\S*\s+(?:{SAYS['range']}\s+)?$"
_MARK = (
    rf"(?i)(?:[=:≈|\t]|\bis\b)[\s=:|~≈]{{0,40}}(?:(?:about|ca\.?|approx\S{{0,20}}"
    rf"|{SAYS['value']})[\s=:|~≈]{{1,40}})?$"
)


class _Quantity(NamedTuple):
    """A number that may be I_zz, and the words around it.

    Of "Our fit gives I_zz = 4.40 g m^2 for the ball, with u = 0.03 g m^2":

    * `before` is "Our fit gives I_zz =";
    * `remark` is " for the ball";
    * `following` is " for the ball, with u = 0.03 g m^2", and some lines below.
    """

    read: Reported
    before: str  # all words since the last quantity, or the unfinished line above
    remark: str  # up to the next number, sign or word such as "and"
    following: str
    end: int  # place of its end in the sentence

    @property
    def is_denied(self) -> bool:
        """Whether words say that it is no answer; a person must look at two numbers."""
        in_front = re.search(_TWO_NUMBERS, self.before)
        return bool(in_front or re.search(SAYS["denied"], self.following))

    @property
    def is_unsure(self) -> bool:
        """Whether the last words in front are those of an uncertainty."""
        return _is_unsure(re.split(r"\d", self.before)[-1])


def _candidates(
    document: Document, sentences: Sequence[tuple[int, str]]
) -> Iterator[Candidate]:
    """Find the quantities of sentences that may be the answer."""
    unfinished = heading = ""
    for at, (number, sentence) in enumerate(sentences):
        below = [text for _, text in sentences[at + 1 : at + MOST_BELOW]]
        end = 0
        for quantity in _quantities(sentence, number, unfinished, below):
            end = quantity.end
            if not quantity.is_denied:
                yield from _candidate(quantity, heading, document)
            heading = f"{heading} | {quantity.before}"
        # A heading is above all values below it; titles of a table are in its rows
        # already.
        heading = heading if end else sentence
        unfinished = ""
        if "|" not in sentence.strip(" |"):
            ends = r"(?<![m^])\d|[.!?;](?:\s|$)|\)\s*$"
            unfinished = re.split(ends, sentence[end:])[-1]


def _quantities(
    sentence: str, number: int, unfinished: str, below: Sequence[str]
) -> Iterator[_Quantity]:
    """Give the quantities of a sentence.

    `number` is that of its line, `unfinished` the end of the sentence above that it
    goes on with, and `below` the sentences that follow.
    """
    end, before = 0, ""
    for start in (match.start() for match in re.finditer(_START, sentence)):
        if start < end:
            continue
        words = sentence[end:start]
        if not end:
            words = f"{unfinished} | {words}"
        value = _value(sentence[start : start + _LONGEST_VALUE], words)
        if value is None:
            continue
        end = start + value[1]
        # "between 4.4e-3 kg m^2 and 4.5e-3 kg m^2": a name counts for both.
        if not re.fullmatch(rf"[\s,|]*+{SAYS['range']}?\s*", words):
            before = words
        rest = sentence[end:]
        following = " | ".join([rest, *below])[:_LONGEST_SENTENCE]
        end_of_words = rf"[.,;|]|\d|\b{SAYS['joining']}\b|\([^()]*:|{_OTHER_VALUE}"
        remark = re.split(end_of_words, rest)[0]
        read = read_reported("inertia", value[0], number)
        quantity = _Quantity(read, before, remark, following, end)
        # A row of an uncertainty does not get that of the next row.
        read = with_u(read, rest if quantity.is_unsure else following)
        yield quantity._replace(read=read)


def _candidate(
    quantity: _Quantity, heading: str, document: Document
) -> Iterator[Candidate]:
    """Give a quantity as an answer, unless the words around say that it is none.

    Those are words of another value (``other`` in answers.toml), words of an
    uncertainty, or, for a value without u, words that do not name I_zz.
    """
    read, before, remark, following, _ = quantity
    has_u = read.u is not None
    is_result = re.search(SAYS["result"], f"{heading} | {before}") is not None
    is_named = is_result or _names_inertia(before)
    # Without its own u, a value behind a word of u is an uncertainty.
    if not has_u and (quantity.is_unsure or not is_named):
        return
    around = f"{before}\n{remark}"
    compared = re.search(SAYS["other"], around) is not None
    if compared:
        around = re.sub(SAYS["comparison"], " ", around)
        if not (is_named and has_u) or re.search(SAYS["other"], around):
            return
    rank = Rank(
        is_named,
        has_u and read.fault != "wrong unit",
        is_result and not re.search(r"\d", before),
        _version_around(before, remark),
    )
    place = f"{document.name}, line {read.line}"
    has_second_u = re.search(SAYS["second_u"], following) is not None
    yield Candidate(rank, place, read, document.doubt, compared, has_second_u)


# --- versions: a draft, a corrected and a final value ---

_RANKS = {"draft": -1, "new": 1, "final": 98}
"""The words of a version, in their order; without one it is 0."""


def version_in(text: str) -> int:
    """Return the rank of the version that the last of such words states.

    "old" is -1, "new" is 1, "v3" is 2, "final" is 98, and a text without them 0.
    """
    words = [*re.finditer(SAYS["version"], text)]
    if not words:
        return 0
    return _version(words[-1])


def _version_around(before: str, remark: str) -> int:
    """Return the rank of the version that the words around a value state.

    "Final results" is the title of a part, but "Corrected value:" belongs to the next
    line.
    """
    belongs = re.search(r":\s*\|", before)
    in_front = before if belongs else before.rpartition(" | ")[2]
    return version_in(in_front) or version_in(remark)


def _version(words: re.Match[str]) -> int:
    if words["number"]:
        return int(words["number"]) - 1
    return _RANKS.get(words.lastgroup or "", 0)


# --- the value of a quantity ---


def _cuts(text: str) -> Iterator[tuple[str, bool]]:
    """Give the beginnings of a text that may be a value, the longest first.

    The second part of each result shows whether no other word follows.
    """
    for cut in reversed(list(re.finditer(_CUT, text))):
        at = cut.start()
        value = text[:at].strip(" |_").rstrip(".,;")
        if value.count(")") > value.count("("):
            value = value.removesuffix(")")
        is_whole = re.match(r"\s*(?:[,;.|(]|$)", text[at:]) is not None
        yield value, is_whole


class _Label(NamedTuple):
    """The words directly in front of a value."""

    name: str = ""
    unit: str = ""  # in brackets behind the name
    is_near: bool = False  # whether they name I_zz


def _label_of(before: str) -> _Label:
    mark = re.search(_MARK, before)
    if mark is None:
        return _Label()
    label = before[: mark.start()]
    name, unit = label, ""
    if match := re.search(_UNIT_AT_END, label):
        name = label[: match.start()]
        unit = "".join(match.groups("")).lstrip(" x×·*")
    return _Label(name, unit, _names_inertia(name, near=True))


def _value(text: str, before: str) -> tuple[str, int] | None:
    """Find a value at the beginning of a text, as `read_reported` reads it.

    The result also contains the length of the value in the text.

    It has a unit of I_zz, or the name of I_zz directly in front, perhaps with a unit in
    brackets.
    """
    label = _label_of(before)
    if not label.is_near and not re.search(_UNIT, text):
        return None
    for cut, is_whole in _cuts(text):
        value = _value_of(cut, is_whole, label)
        if value:
            return value, len(cut)
    return None


def _value_of(cut: str, is_whole: bool, label: _Label) -> str:
    """Return a text as `read_reported` reads it, or "" if it is no value of I_zz."""
    if label.is_near and label.unit:
        with_unit = f"{cut} {label.unit}"
        if read_reported("inertia", with_unit).fault is None:
            return with_unit
    read = read_reported("inertia", cut)
    if read.fault is None:
        return cut
    if is_whole and _is_nearly_value(read, cut, label):
        return cut
    return ""


def _is_nearly_value(read: Reported, cut: str, label: _Label) -> bool:
    """Return whether a number behind the name of I_zz lacks the right unit alone.

    "I_zz = 4.4e-3 ± 0.1e-3 kg/m^2" is an answer, and its unit costs a point.
    """
    if not label.is_near:
        return False
    if read.u is not None:
        has_other_unit = re.fullmatch(_OTHER_UNIT, cut) is not None
        return has_other_unit or read.fault == "no unit"
    # A single letter may be the name of anything.
    has_long_name = re.search(r"\w\w\W*$", label.name) is not None
    return has_long_name and read.fault == "no unit"


def _names_inertia(text: str, near: bool = False) -> bool:
    """Return whether words name I_zz, with `near` the last of them.

    A single letter must be next to the value.
    """
    # Without brackets, and without a verb at the end.
    text = re.sub(rf"[\[(][^\])]{{0,300}}[\])]|\b{SAYS['verb']}\W*$", " ", text)
    words = re.findall(r"[^\W\d][\w'’]*", text.replace("_", ""))
    ends = range(len(words) if near else 1, len(words) + 1)
    for end in ends:
        for count in (1, 2, 3):
            name = " ".join(words[max(0, end - count) : end])
            counts = len(name) > 1 or end == len(words)
            if counts and name_roles(name)[0] == ("inertia",):
                return True
    return False


# --- the uncertainty of a quantity ---


def with_u(read: Reported, behind: str) -> Reported:
    """Add the uncertainty that follows an answer in words.

    To "4.4e-3 kg m^2", `behind` may be " with an error of 0.1e-3 kg m^2".
    """
    # "The deviation divided by 3 gives 0.1e-3 kg m^2": the 3 is not meant.
    start = rf"(?!{_COUNT})(?=\d|(?<=\s)[.,]\d)"
    gap = re.match(
        rf"((?:[^\d±]|{_COUNT}){{1,80}}?±?)(?:[\[(]([^\[\]()]*)[\])])?[\s=:|]*{start}",
        behind,
    )
    if gap is None or read.u is not None:
        return read
    number = behind[gap.end() :][:_LONGEST_VALUE]
    words = " ".join([gap[1], *re.findall(r"^[\d.,]+\s*%\s*([^\W\d]+)", number)])
    if not _is_unsure(words) or re.search(SAYS["other"], words):
        return read
    unit = gap[2] or ""
    if not kinds_of(unit):
        unit = ""
    return _with_number(read, number, unit, _other_words(words))


def _other_words(words: str) -> list[str]:
    """Return the words that are neither of an uncertainty nor of I_zz."""
    return [
        word
        for word in re.findall(r"[^\W\d_]{4,}", words)
        if not _is_unsure(word) and not _names_inertia(word)
    ]


def _with_number(
    read: Reported, number: str, unit: str, others: Sequence[str]
) -> Reported:
    """Add the uncertainty with which a text begins, behind some other words."""
    is_plain = all(re.fullmatch(SAYS["small"], word) for word in others)
    # Without a unit of its own, the number may be of anything that is said in between.
    is_of_other = any(name_roles(word)[0] for word in others)
    for cut, is_whole in _cuts(number):
        has_unit = re.search(_UNIT, cut) is not None
        is_clear = is_plain and (is_whole or "%" in cut)
        if not is_clear and (is_of_other or not has_unit):
            continue
        both = _with_text(read, f"{cut} {unit}")
        if both is not None:
            return both
    return read


def _with_text(read: Reported, u: str) -> Reported | None:
    """Return a value with an uncertainty in words; None if the value changes by it.

    An uncertainty larger than the value is none.
    """
    text = " ".join(f"{read.text} ± {u}".replace("|", " ").split())
    both = read_reported("inertia", text, read.line)
    if (both.fault, both.value) != (read.fault, read.value):
        return None
    size = abs(read.value or 0)
    return both if (both.u or 0) < size else read
