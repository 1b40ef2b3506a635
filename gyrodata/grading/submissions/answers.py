"""Find the answer in the texts of a student.

All quantities that may be I_zz are found, and the best named quantity is used.

A text becomes sentences: lines without markup, and rows of tables as lines. A number in
a sentence is a candidate if it has a unit of I_zz, or if the name of I_zz is directly
in front of it. Words around it say whether it is another value, such as one of theory.
Nothing is guessed: of two different candidates that are equally good, neither is taken.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain, filterfalse, islice, takewhile, zip_longest
from pathlib import PurePosixPath

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import readings
from gyrodata.base.errors import Diagnostic
from gyrodata.fitting import K_95
from gyrodata.grading.submissions import visible
from gyrodata.grading.submissions.documents import (
    LONGEST_LINE,
    MOST_LINES,
    NO_TEXT,
    PLAIN,
    SAYS,
    Document,
    Unseen,
    in_cells,
    read_document,
    without_marks,
)
from gyrodata.quantities.numerals import to_float
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import Faults, Reported, read_reported
from gyrodata.readings.names import name_roles
from gyrodata.readings.roles import is_key
from gyrodata.readings.words import UNSURE_WORDS, squeezed_words

_MOST_VALUES, _MOST_BELOW, _MOST_NAMES = 100, 7, 100
_LONGEST_SENTENCE, _LONGEST_VALUE = 1000, 120


class Answers(Struct, frozen=True):
    """The value that a student reports, from any of the files."""

    inertia: Reported | None = None  # I_zz [kg*m^2]; None if nothing is reported
    diagnostics: tuple[Diagnostic, ...] = ()  # notes on how it was read
    file: str = ""  # name of the file with I_zz
    questions: tuple[str, ...] = ()  # to a person, about the answer
    rivals: tuple[Rival, ...] = ()  # other values, by words of a comparison
    unread: tuple[Diagnostic, ...] = ()  # each a file that cannot be read


class Rival(Struct, frozen=True):
    """A named value next to the answer that differs, and that no word of theory explains."""

    value: float  # [kg*m^2]
    question: str  # to a person


class _Candidate(Struct, frozen=True):
    """A quantity that may be the answer.

    One with an uncertainty is better, then one that is called a result.
    """

    rank: tuple[
        bool, bool, bool, int
    ]  # whether it has a name, an uncertainty, words of a result; and its version
    place: str
    read: Reported
    doubt: bool = False  # whether a person may not see it
    compared: bool = False  # whether it is no answer by a word of a comparison alone

    @property
    def file(self) -> str:
        return self.place.rpartition(", line ")[0]


class _Text(Struct, frozen=True):
    """The values in a document, and why a part of it is not read."""

    values: Sequence[_Candidate]
    cut: str = ""  # question about a value that may be in a part that is not read


def read_answers(
    log: readings.Readings | None,
    reports: Iterable[Document | tuple[str, bytes]] = (),
    unseen: Unseen | None = None,
) -> Answers:
    """Find the value that the log reports, or another text if the log reports none.

    `reports` are the other texts, or their names and bytes, and `unseen` what is hidden
    in the log. Never raises: a value that cannot be read has a fault.
    """
    documents = [
        one if isinstance(one, Document) else read_document(*one) for one in reports
    ]
    unseen = unseen or Unseen()
    if log is not None and not _is_seen(log, unseen):
        log = None
    remarks = [Document(log.name, _remarks(log))] if log is not None else []
    texts = [_read(one) for one in (*remarks, *documents)]
    found = [one for text in texts for one in text.values if not one.compared]
    if log is not None:
        chosen = _Candidate(
            (True, True, True, 0), log.name, _in_log(log), _is_doubted(log, unseen)
        )
        answers = Answers(chosen.read, (), log.name)
    elif found:
        chosen, answers = _best(found)
    else:
        return Answers(unread=_unread(documents, has_answer=False))
    questions = [text.cut for text in texts] + [_doubt(chosen, found)]
    if answers.inertia and answers.inertia.fault != "given twice":
        others = [one for one in found if not _is_corrected(one, chosen)]
        questions.append(_disagrees(chosen.read, answers.file, others))
    rivals = (one for text in texts for one in text.values if one.compared)
    return replace(
        answers,
        questions=tuple(filter(None, questions)),
        rivals=tuple(
            Rival(one.read.value or 0.0, _two_answers(chosen.read, answers.file, one))
            for one in rivals
            if _differ(chosen.read, one.read)
        ),
        unread=_unread(documents, has_answer=True),
    )


def _unread(documents: Iterable[Document], has_answer: bool) -> tuple[Diagnostic, ...]:
    """Name the files that cannot be read; a PDF of pictures may be a plot."""
    return tuple(
        Faults(one.name)
        .refuse("file_of_class_unreadable", name=one.name, why=one.problem)
        .diagnostics[0]
        for one in documents
        if one.problem and not (has_answer and one.problem == NO_TEXT)
    )


def _in_log(log: readings.Readings) -> Reported:
    """Return the value that a log reports, with what the lines below it say of it."""
    read = log.reported["inertia"]
    # Its line and those below it may say more, such as "I_zz = 4.4 g m^2,
    # u = 0.1 g m^2" in several cells.
    top = max(0, (read.line or 0) - 1)
    lines = in_cells(
        readings.lablog.split_lines(log.source_text), slice(top, top + _MOST_BELOW)
    )
    more = _read(Document("", lines)).values if read.u is None or read.fault else ()
    same = (
        one.read
        for one in more
        if one.read.u is not None and one.read.value == read.value
    )
    return replace(next(same, _with_u(read, "".join(lines[1:2]))), line=read.line)


def _best(found: Sequence[_Candidate]) -> tuple[_Candidate, Answers]:
    """Return the candidate that is the answer; of two equally good ones, it is neither."""
    # A draft is an answer only if it is the only one.
    found = [one for one in found if one.rank[0] and not _is_draft(one)] or found
    best = max(one.rank for one in found)
    equal = [one for one in found if one.rank == best]
    versions = [version_of(one.file) for one in equal]
    if len({base for _, base in versions}) == 1:
        equal = [
            one
            for one, (rank, _) in zip(equal, versions, strict=True)
            if rank == max(versions)[0]
        ]
    # The same answer may be written with more digits.
    chosen = max(equal, key=lambda one: one.read.step or 0.0)
    read, others = (
        chosen.read,
        [one for one in equal if not _agree(chosen.read, one.read)],
    )
    if others:
        first, second = (
            f'"{one.read.text}" in {one.place}' for one in (chosen, others[0])
        )
        problem = f"two values are found: {first} and {second}"
        read = Reported(
            "inertia", read.text, fault="given twice", problem=problem, line=read.line
        )
    note = Diagnostic.named("answer_elsewhere", place=chosen.place, text=read.text)
    return chosen, Answers(read, (note,), chosen.file)


def _is_corrected(one: _Candidate, chosen: _Candidate) -> bool:
    """Return whether the text calls a value an earlier one, and the answer a later one."""
    return one.file == chosen.file and one.rank[3] < 0 < chosen.rank[3]


def _is_draft(one: _Candidate) -> bool:
    return version_of(one.file)[0] < 0


def _is_seen(log: readings.Readings, unseen: Unseen) -> bool:
    """Return whether a log has an answer that a person who opens it may see."""
    if "inertia" not in log.reported:
        return False
    line = log.reported["inertia"].line
    if line is None:
        return True
    above = [title.strip("'") for before, title in log.sheets if before < line]
    text = readings.lablog.split_lines(log.source_text)[line - 1]
    return unseen.sheets.isdisjoint(above[-1:]) and visible.line_seen(text) == text


def _is_doubted(log: readings.Readings, unseen: Unseen) -> bool:
    """Return whether the answer of a log is in a cell that is not shown."""
    text = log.reported["inertia"].text
    return any(text in cell for cell in unseen.cells)


def _doubt(chosen: _Candidate, found: Iterable[_Candidate]) -> str:
    """Ask about an answer that a person may not see, unless it is elsewhere too."""
    if not chosen.doubt or any(
        one.rank[0] and not one.doubt and _agree(chosen.read, one.read) for one in found
    ):
        return ""
    where = f'the answer "{chosen.read.text}" in {chosen.place}'
    return f"{where} may be hidden; look whether the file shows it"


def _remarks(log: readings.Readings) -> list[str]:
    """Return the lines of a log that are remarks.

    All other lines are empty: lines that are not remarks, and lines that the reader
    reads.
    """
    found: list[str] = []
    for line in readings.lablog.split_lines(log.source_text):
        remark = without_marks(visible.line_seen(line)).strip('#%," \t')
        is_remark = line.lstrip(' "').startswith(("#", "%")) and not is_key(
            re.split("[:=]", remark)[0].strip()
        )
        found.append(remark if is_remark else "")
    return found if any(re.search(r"\d", remark) for remark in found) else []


def _disagrees(read: Reported, file: str, found: Sequence[_Candidate]) -> str:
    """Describe another value with a name that differs by more than both uncertainties."""
    for one in found:
        if one.file != file and (_is_draft(one) or re.search(r"\.[ct]sv$", one.file)):
            continue  # a draft or an earlier log may have another answer
        if one.rank[0] and _differ(read, one.read):
            return _two_answers(read, file, one)
    return ""


def _two_answers(read: Reported, file: str, other: _Candidate) -> str:
    used = f'two answers: "{read.text}" in {file} is used'
    return f'{used}, and "{other.read.text}" is in {other.place}'


# the uncertainty of another value that is reported without one, as a share of it
WITHOUT_U = 0.05
# a smaller share of the answer, without an uncertainty, may be the uncertainty of the
# answer
SMALL = 0.2


def _differ(read: Reported, other: Reported) -> bool:
    """Return whether two values are farther from each other than their uncertainties allow."""
    value, another = read.value or 0.0, other.value or 0.0
    if other.u is None and abs(another) < SMALL * abs(value):
        return False
    return abs(value - another) > (read.u or 0.0) + (
        WITHOUT_U * abs(another) if other.u is None else other.u
    )


_RANKS = {
    "draft": -1,
    "new": 1,
    "final": 98,
}  # the words of a version, in their order; without one it is 0


def version_of(name: str) -> tuple[int, str]:
    """Return the rank of the version that the name of a file states, and the name without it."""
    stem = PurePosixPath(name.lower()).stem
    found = re.search(SAYS["version"], stem)
    rank = _RANKS.get(found.lastgroup or "", 0) if found else 0
    return int(found["number"]) - 1 if found and found["number"] else rank, re.sub(
        SAYS["version"], "", stem
    )


def _version_in(text: str) -> int:
    """Return the rank of the version that words next to a value state last."""
    # "Final results" is the title of a part, "Corrected value:" belongs to the next line.
    line = text if re.search(r":\s*\|", text) else text.rpartition(" | ")[2]
    words = [*re.finditer(SAYS["version"], line)]
    return _RANKS.get(words[-1].lastgroup or "", 0) if words else 0


def _agree(rounded: Reported, other: Reported) -> bool:
    """Return whether two values with their uncertainties are the same but for rounding."""
    near = abs((rounded.value or 0.0) - (other.value or 0.0)) <= 0.501 * (
        rounded.step or 0.0
    )
    return near and abs((rounded.u or 0.0) - (other.u or 0.0)) <= 0.501 * (
        rounded.u_step or 0.0
    )


# --- names, and the sentences of a file ---


def partners_in(
    log: readings.Readings | None, reports: Iterable[Document | tuple[str, bytes]]
) -> str:
    """Return the partners that lines of the log name, or of the reports without a log.

    Behind ``~`` are all words of any text that may be a name.
    """
    documents = [
        one if isinstance(one, Document) else read_document(*one) for one in reports
    ]
    texts = ["\n".join(one.lines) for one in documents]
    with_lines = texts if log is None else [log.source_text]
    lines = chain.from_iterable(
        re.finditer(SAYS["partner"], text, re.M) for text in with_lines
    )
    names = (one[1].strip() for one in islice(lines, _MOST_NAMES))
    named = " & ".join(names)[:_LONGEST_SENTENCE]
    called: dict[str, None] = {}
    for text in with_lines if log is None else [*with_lines, *texts]:
        for one in re.finditer(SAYS["called"], text):
            words = re.split("[ ,]+", one[0][:_LONGEST_SENTENCE])
            # "Team Ann Lee" contains "Ann Lee".
            parts = (
                words[at : at + size]
                for size in (2, 3, 4)
                for at in range(len(words) - size + 1)
            )
            called |= dict.fromkeys(" ".join(part) for part in parts)
            if len(called) > _MOST_NAMES:
                break
    said = list(called)[:_MOST_NAMES]
    return named + (f" ~ {' & '.join(said)}" if said else "")


def _sentences(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Split lines into sentences without markup, each with the number of its line."""
    found, plain = [], [line[:LONGEST_LINE] for line in lines]
    for pattern, text in PLAIN:
        plain = [line and re.sub(pattern, text, line) for line in plain]
    for number, line in enumerate(_with_titles(plain), 1):
        found += [
            (number, one)
            for one in re.split(
                r"(?<=[!?;])\s+(?=[^\W\d])|(?<=\.)\s+(?=[A-ZÀ-ÝΘ])", line
            )
        ]
    return [(number, one) for number, one in found if one.strip()]


def _with_titles(lines: Sequence[str]) -> Iterator[str]:
    """Write the rows of a table as people write in lines.

    The sign ± is in front of an uncertainty, and units are behind the numbers.
    """
    titles, width = list[str](), 0
    runs = [_is_number(line.strip(" |")) for line in ["", *lines, ""]]
    for at, line in enumerate(lines):
        cells = [cell.strip(" *") for cell in re.sub(_OUTER_BARS, "", line).split("|")]
        if not any(map(_is_number, cells)):
            titles, width = (
                (titles, width)
                if set(line) <= set("-: |")
                else (cells * (len(cells) > 1), 0)
            )
        elif len(cells) > 1:
            # Titles on the right of a table of runs have values in as many cells.
            width = width or len(cells)
            titles = titles if width <= len(titles) or len(cells) == width else []
            # A column of I_zz with a value for each run is not the answer.
            alone = runs[at : at + 3] == [False, True, False]
            line, missing = "", [""] * (len(cells) - len(titles))
            columns = list(zip_longest([*missing, *titles], cells, fillvalue=""))
            # A unit goes behind the numbers.
            ahead = [
                it
                for it in takewhile(lambda it: not _is_number(it[1]), columns)
                if "inertia" in kinds_of(it[1])
            ]
            columns = [*(one for one in columns if one not in ahead), *ahead]
            # The name of a row may have its unit.
            unit = (
                ""
                if runs[at + 1]
                else next(
                    filter(None, map(_unit_behind, filterfalse(_is_number, cells))), ""
                )
            )
            unsure = (
                ""
                if runs[at + 1] or any(map(_is_unsure, titles))
                else _plain_u(columns, unit)
            )
            for title, cell in columns:
                number, small = _is_number(cell), cell == unsure
                if unit and not number:
                    cell = re.sub(r"(?:(?<!\s)\s+)?[\[(][^\[\]()]*[\])]$", "", cell)
                if number and not re.search(_UNIT, cell):
                    cell = f"{cell} {_unit_behind(title) or unit}".rstrip()
                if number and line and (_is_unsure(title) or small):
                    line += f" ± {cell}{' %' * ('%' in title)}"
                elif not number and (
                    not cell or _unit_behind(f"/{cell}") or kinds_of(cell)
                ):
                    line += f" {cell}"
                else:
                    line += (
                        f" | {title} = {cell}"
                        if alone or re.search(SAYS["other"], title)
                        else f" | {cell}"
                    )
        yield line


def _is_number(text: str) -> bool:
    return re.match(rf"\s*+[-+(]*+(?!{_POWER})[.,]?\d", text) is not None


def _plain_u(columns: Sequence[tuple[str, str]], unit: str) -> str:
    """Return the second of two numbers with a unit, if it is an uncertainty.

    An uncertainty is a small part of the first number.
    """
    numbers = [cell for _, cell in columns if _is_number(cell)]
    both = read_reported("inertia", f"{' ± '.join(numbers)} {unit or columns[-1][1]}")
    return (
        numbers[1]
        if numbers[1:]
        and both.fault is None
        and 0 < (both.u or 0) < 0.2 * abs(both.value or 0)
        else ""
    )


def _is_unsure(text: str) -> bool:
    """Return whether words contain one of an uncertainty."""
    return (
        bool(squeezed_words(text) & UNSURE_WORDS)
        or re.search(SAYS["unsure"], text) is not None
    )


def _unit_behind(text: str) -> str:
    """Return the unit of I_zz, or the power of ten, in a name or title.

    It is in brackets, as in "Value (10⁻³ kg m²)".
    """
    found = re.search(
        rf"(?:[\[(]|\bin\b|/)\s*({_POWER})?([^\[\]()|/]*)[\])]?[\s*_]*$", text
    )
    power, unit = found.groups("") if found else ("", "")
    return (
        power.lstrip(" x×·*") + unit
        if (power and not unit) or "inertia" in kinds_of(unit)
        else ""
    )


# --- the candidates ---

_UNIT = r"(?i)g[\s·*.⋅/-]{0,3}[cm]?m|n[\s·*.⋅]*m"
_HAS_UNIT = re.compile(
    r"(?<![A-Za-z])(?i:k?g[\s·*.⋅-]{0,3}[ckm]?m(?:\b|\W{0,3}[2²])"
    r"|n[\s·*.⋅]{0,3}m[\s·*.⋅]{0,3}s)"
)
"""A unit of I_zz in a text that is not read."""
_OTHER_UNIT = (
    r"[\d.,()±+/−⁻⁰-⁹\s×x*·^eE-]+?[kmc]{0,2}[gN](?:[\s·*⋅./]*(?:[ckm]?m|s|rad)(?:\^"
    r"|\*\*)?[\d²³]?){1,3}"
)
_POWER = r"[x×·*\s]*10\s?\^?\s?[-−⁻]\s?[\d⁰¹²³⁴-⁹]+\s*"
_START = r"(?<![\w.,^(+\-−±/*×·])(?<![/*×·]\s)\(?[-+−]?\(?(?:\d|[.,]\d)"
_CUT = r"[,;.|]?\s+|(?<![.,;|])[.,;|]*$"
_OUTER_BARS = r"^\|(?:[\s|]+$)?|(?<![\s|])[\s|]+$"
_COUNT = r"(?<![\w.,])\d{1,2}(?=\s(?!percent|per cent|Prozent)(?i:[^\W\d]{3}|is\b|es\b|we\b))"
_TWO_NUMBERS = rf"(?<![\w.,^])\d\S*\s+(?:{SAYS['range']}\s+)?$"
_MARK = (
    rf"(?i)(?:[=:≈|\t]|\bis\b)[\s=:|~≈]{{0,40}}(?:(?:about|ca\.?|approx\S{{0,20}}"
    rf"|{SAYS['value']})[\s=:|~≈]{{1,40}})?$"
)


def _read(document: Document) -> _Text:
    """Find the quantities of a document that may be the answer."""
    filled = [at for at, line in enumerate(document.lines, 1) if line.strip()]
    end = filled[MOST_LINES - 1] if len(filled) > MOST_LINES else len(document.lines)
    sentences = _sentences(document.lines[:end])
    short = [one for one in sentences if len(one[1]) <= _LONGEST_SENTENCE]
    values = list(islice(_candidates(document, short), _MOST_VALUES + 1))
    unread = chain(
        document.lines[end:],
        (line[LONGEST_LINE:] for line in document.lines[:end]),
        (text for _, text in sentences if len(text) > _LONGEST_SENTENCE),
    )
    if len(values) <= _MOST_VALUES and not any(map(_HAS_UNIT.search, unread)):
        return _Text(values)
    cut = f"{document.name} is too long: a part of it is not read"
    cut += ", and may have another answer"
    return _Text(values[:_MOST_VALUES], cut)


def _candidates(
    document: Document, sentences: Sequence[tuple[int, str]]
) -> Iterator[_Candidate]:
    """Find the quantities of sentences that may be the answer."""
    above = heading = ""
    parts_of_mean: list[Reported] = []
    for at, (number, sentence) in enumerate(sentences):
        end, before = 0, ""
        for start in (match.start() for match in re.finditer(_START, sentence)):
            if start < end:
                continue
            words = f"{above} | {sentence[:start]}" if not end else sentence[end:start]
            text = sentence[start : start + _LONGEST_VALUE]
            value = _value(text, words) or _mean(text, words, parts_of_mean)
            if value is None:
                continue
            # "between 4.4e-3 kg m^2 and 4.5e-3 kg m^2": a name counts for both.
            before = (
                before
                if re.fullmatch(rf"[\s,|]*+{SAYS['range']}?\s*", words)
                else words
            )
            end = start + value[1]
            below = [one for _, one in sentences[at + 1 : at + _MOST_BELOW]]
            behind = " | ".join([sentence[end:], *below])[:_LONGEST_SENTENCE]
            # A row of an uncertainty does not get that of the next row.
            unsure = _is_unsure(re.split(r"\d", before)[-1])
            read = _with_u(
                read_reported("inertia", value[0], number),
                sentence[end:] if unsure else behind,
            )
            after = re.split(
                rf"[.,;|]|\d|\b{SAYS['joining']}\b|\([^()]*:", sentence[end:]
            )[0]
            parts_of_mean = [*parts_of_mean, read][-_MOST_PARTS:]
            # A person must look at two numbers; without its own u, a value behind a
            # word of u is an uncertainty.
            bad = ((_TWO_NUMBERS, before), (SAYS["denied"], behind))
            around = f"{before}\n{after}"
            is_other = re.search(SAYS["other"], around) is not None
            result, u = (
                re.search(SAYS["result"], f"{heading} | {before}") is not None,
                read.u is not None,
            )
            named = result or _names_inertia(before)
            compared = is_other and named and u and _is_compared(around)
            if (
                not any(re.search(*one) for one in bad)
                and (u or (named and not unsure))
                and (compared or not is_other)
            ):
                version = _version_in(before) or _version_in(after)
                rank = (
                    named,
                    u and read.fault != "wrong unit",
                    result and not re.search(r"\d", before),
                    version,
                )
                place = f"{document.name}, line {number}"
                yield _Candidate(
                    rank, place, read, number in document.doubted, compared
                )
            heading = f"{heading} | {before}"
        # A heading is above all values below it; titles of a table are in its rows
        # already.
        heading = heading if end else sentence
        # The beginning of a sentence that goes on.
        parts = re.split(r"(?<![m^])\d|[.!?;](?:\s|$)|\)\s*$", sentence[end:])
        above = "" if "|" in sentence.strip(" |") else parts[-1]


def _is_compared(around: str) -> bool:
    """Return whether only words of a comparison say that a value is not the answer."""
    return not re.search(SAYS["other"], re.sub(SAYS["comparison"], " ", around))


def _cuts(text: str) -> Iterator[tuple[str, bool]]:
    """Give the beginnings of a text that may be a value, the longest first.

    The second part of each result shows whether no other word follows.
    """
    for cut in reversed(list(re.finditer(_CUT, text))):
        value = text[: cut.start()].strip(" |_").rstrip(".,;")
        value = (
            value.removesuffix(")") if value.count(")") > value.count("(") else value
        )
        yield value, re.match(r"\s*(?:[,;.|(]|$)", text[cut.start() :]) is not None


def _value(text: str, before: str) -> tuple[str, int] | None:
    """Find a value at the beginning of a text, as `read_reported` reads it.

    The result also contains the length of the value in the text.

    It has a unit of I_zz, or the name of I_zz directly in front, perhaps with a unit in
    brackets.
    """
    mark = re.search(_MARK, before)
    label = before[: mark.start()] if mark else ""
    unit = re.search(r"(?:[\[(]|\bin\b|/)\s*([^\[\]()|/]*)[\])]?[\s*_]*$", label)
    name = label[: unit.start()] if unit else label
    near = mark is not None and _names_inertia(name, near=True)
    if not near and not re.search(_UNIT, text):
        return None
    for cut, whole in _cuts(text):
        with_unit = f"{cut} {unit[1].lstrip(' x×·*')}" if near and unit else ""
        if with_unit and read_reported("inertia", with_unit).fault is None:
            return with_unit, len(cut)
        read = read_reported("inertia", cut)
        long = near and whole and (read.u is not None or re.search(r"\w\w\W*$", name))
        # "I_zz = 4.4e-3 ± 0.1e-3 kg/m^2" is an answer, and its unit costs a point.
        almost = read.fault == "no unit" or (
            read.u is not None and re.fullmatch(_OTHER_UNIT, cut)
        )
        if read.fault is None or (long and almost):
            return cut, len(cut)
    return None


_MOST_PARTS, _LONGEST_MEAN = 20, 40


def _mean(text: str, before: str, parts: Sequence[Reported]) -> tuple[str, int] | None:
    """Find a mean without a unit: it has that of the values in front, and is between."""
    mark = re.search(_MARK, before)
    if mark is None or not re.search(rf"{SAYS['result']}\W*$", before[: mark.start()]):
        return None
    values = [one.value for one in parts if one.value is not None]
    unit = re.search(r"(?:[kmc]?g|N)(?![a-z]).*$", parts[-1].text) if parts else None
    if unit is None or len(values) < 2:
        return None
    for cut, _ in _cuts(text[:_LONGEST_MEAN]):
        read = read_reported("inertia", f"{cut} {unit[0]}")
        if read.fault is None and min(values) <= (read.value or 0.0) <= max(values):
            return read.text, len(cut)
    return None


def _names_inertia(text: str, near: bool = False) -> bool:
    """Return whether words name I_zz, with `near` the last of them.

    A single letter must be next to the value.
    """
    # Without brackets, and without a verb at the end.
    text = re.sub(rf"[\[(][^\])]{{0,300}}[\])]|\b{SAYS['verb']}\W*$", " ", text)
    words = re.findall(r"[^\W\d][\w'’]*", text.replace("_", ""))
    ends = range(len(words) if near else 1, len(words) + 1)
    names = [
        (" ".join(words[max(0, end - count) : end]), end)
        for end in ends
        for count in (1, 2, 3)
    ]
    return any(
        name_roles(name)[0] == ("inertia",)
        for name, end in names
        if len(name) > 1 or end == len(words)
    )


def _with_u(
    read: Reported, behind: str, first: Sequence[str] = ("total", "of_mean")
) -> Reported:
    """Add the uncertainty that follows an answer in words.

    An example is "with an error of 0.1e-3 kg m^2".
    """
    if ends := re.match(
        rf"[^\d\n]{{0,30}}(68|95) ?%[^\d\n]{{0,40}}(\d\S*)\s*{SAYS['range']}\s*(\d[^\s)\]]*)",
        behind,
    ):
        with suppress(ValueError):
            low, high = map(to_float, ends.groups()[1:])
            u = (high - low) / (2 if ends[1] == "68" else 2 * K_95)
            both = read_reported("inertia", f"{read.text} ± {u:.2g}", read.line)
            return (
                both
                if both.fault == read.fault and 0 < u < abs(read.value or 0)
                else read
            )
    # The total uncertainty goes before its parts, and that of the mean before that of
    # one run.
    for better in first:
        skipped = re.split(SAYS[better], behind, maxsplit=1)[0]
        if skipped and skipped != behind and not re.search(SAYS["other"], skipped):
            read = _with_u(read, behind[len(skipped) :], ())
    # "The deviation divided by 3 gives 0.1e-3 kg m^2": the 3 is not meant.
    number = rf"(?!{_COUNT})(?=\d|(?<=\s)[.,]\d)"
    gap = re.match(
        rf"((?:[^\d±]|{_COUNT}){{1,80}}?±?)(?:[\[(]([^\[\]()]*)[\])])?[\s=:|]*{number}",
        behind,
    )
    number = behind[gap.end() :][:_LONGEST_VALUE] if gap else ""
    said = (
        " ".join([gap[1], *re.findall(r"^[\d.,]+\s*%\s*([^\W\d]+)", number)])
        if gap
        else ""
    )
    if (
        gap is None
        or read.u is not None
        or not _is_unsure(said)
        or re.search(SAYS["other"], said)
    ):
        return read
    more = [
        word
        for word in re.findall(r"[^\W\d_]{4,}", said)
        if not _is_unsure(word) and not _names_inertia(word)
    ]
    plain = all(re.fullmatch(SAYS["small"], word) for word in more)
    unit = gap[2] if kinds_of(gap[2] or "") else ""
    for cut, whole in _cuts(number):
        text = " ".join(f"{read.text} ± {cut} {unit}".replace("|", " ").split())
        both = read_reported("inertia", text, read.line)
        # Without a unit of its own, the number may be of anything that is said in
        # between.
        own = re.search(_UNIT, cut) and not any(name_roles(word)[0] for word in more)
        if (
            both.fault == read.fault
            and both.value == read.value
            and (own or (plain and (whole or "%" in cut)))
        ):
            return both if (both.u or 0) < abs(read.value or 0) else read
    return read
