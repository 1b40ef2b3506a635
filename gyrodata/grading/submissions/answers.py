"""The answer in the texts of a student: all quantities that may be I_zz are found, and the best named one is taken.

A text becomes sentences: lines without markup, and rows of tables as lines. A number in a sentence is a candidate if it
has a unit of I_zz, or if the name of I_zz is directly in front of it. Words around it say whether it is another value,
such as one of theory. Nothing is guessed: of two different candidates that are equally good, neither is taken.
"""

from __future__ import annotations

import csv
import html
import io
import re
import tomllib
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain, filterfalse, islice, takewhile, zip_longest
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import readings
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.fitting import K_95
from gyrodata.grading.submissions import visible
from gyrodata.grading.submissions.archives import TABLES, WORKBOOKS, ending
from gyrodata.quantities import to_float
from gyrodata.readings import Reported, read_reported
from gyrodata.readings.roles import UNSURE_WORDS, is_key, name_roles, squeezed_words
from gyrodata.readings.source import sheet_rows
from gyrodata.units import kinds_of

_WORDS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
_STRUCK, _MARKUP, _PLAIN = (_WORDS.pop(key) for key in ("struck", "markup", "plain"))
SAYS = {key: f"(?i:{''.join(text.splitlines())})" for key, text in _WORDS.items()}
_MOST_LINES, _MOST_VALUES, _MOST_BELOW, _MOST_NAMES = 1000, 100, 7, 100
_PACKED = {".docx": "word/document.xml", ".odt": "content.xml"}
"""The part of a file of a word processor that contains its text."""
_LONGEST_LINE, _LONGEST_SENTENCE, _LONGEST_VALUE = 20_000, 1000, 120


class Answers(Struct, frozen=True):
    """The value that a student reports, from any of the files."""

    inertia: Reported | None = None  # I_zz [kg*m^2]; None if nothing is reported
    diagnostics: tuple[Diagnostic, ...] = ()  # notes on how it was read
    file: str = ""  # name of the file with I_zz
    other: str = ""  # in words, another value that disagrees; or ""


class _Candidate(Struct, frozen=True):
    """A quantity that may be the answer; one with an uncertainty is better, then one that is called a result."""

    rank: tuple[
        bool, bool, bool, bool
    ]  # whether it has a name, an uncertainty, words of a result, and of the last one
    place: str
    read: Reported


def read_answers(
    log: readings.Readings | None,
    reports: Iterable[tuple[str, bytes]] = (),
    unseen: Collection[str] = (),
) -> Answers:
    """Find the value that the log reports, or another text if the log reports none.

    `reports` are names and bytes of the other texts, and `unseen` the hidden sheets of the log. Never raises: a value
    that cannot be read has a fault.
    """
    found = [
        one
        for name, data in reports
        for one in islice(_candidates(name, lines_of(name, data)), _MOST_VALUES)
    ]
    if log is not None and "inertia" in log.reported and _is_seen(log, unseen):
        read = log.reported["inertia"]
        # Its line and those below it may say more, such as "I_zz = 4.4 g m^2, u = 0.1 g m^2" in several cells.
        top = max(0, (read.line or 0) - 1)
        lines = _in_cells(
            readings.lablog.split_lines(log.source_text), slice(top, top + _MOST_BELOW)
        )
        more = _candidates("", lines) if read.u is None or read.fault else ()
        same = (
            one.read
            for one in more
            if one.read.u is not None and one.read.value == read.value
        )
        read = replace(next(same, _with_u(read, "".join(lines[1:2]))), line=read.line)
        found = [*islice(_candidates(log.name, _remarks(log)), _MOST_VALUES), *found]
        return Answers(read, (), log.name, _disagrees(read, log.name, found))
    if not found:
        return Answers()
    best = max(one.rank for one in found)
    equal = [one for one in found if one.rank == best]
    versions = [version_of(one.place.rpartition(", line ")[0]) for one in equal]
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
    file = chosen.place.rpartition(", line ")[0]
    return Answers(read, (note,), file, "" if others else _disagrees(read, file, found))


def _is_seen(log: readings.Readings, unseen: Collection[str]) -> bool:
    """Return whether a person who opens the log sees the answer in it."""
    line = log.reported["inertia"].line
    if line is None:
        return True
    above = [title.strip("'") for before, title in log.sheets if before < line]
    text = readings.lablog.split_lines(log.source_text)[line - 1]
    return (
        above[-1:] not in [[one] for one in unseen] and visible.line_seen(text) == text
    )


def _remarks(log: readings.Readings) -> list[str]:
    """Return the lines of a log, with nothing in place of those that are no remarks, or that the reader reads."""
    found: list[str] = []
    for line in readings.lablog.split_lines(log.source_text)[:_MOST_LINES]:
        remark = visible.line_seen(line).strip('#%," \t')
        is_remark = line.lstrip(' "').startswith(("#", "%")) and not is_key(
            re.split("[:=]", remark)[0].strip()
        )
        found.append(remark if is_remark else "")
    return found if any(re.search(r"\d", remark) for remark in found) else []


def _disagrees(read: Reported, file: str, found: Sequence[_Candidate]) -> str:
    """Describe another value with a name that differs by more than both uncertainties."""
    for one in found:
        elsewhere = one.place.rpartition(", line ")[0] != file
        if elsewhere and (
            version_of(one.place)[0] < 0 or re.search(r"\.[ct]sv, line", one.place)
        ):
            continue  # a draft or an earlier log may have another answer
        if one.rank[0] and _differ(read, one.read):
            return f'two answers: "{read.text}" in {file} is used, and "{one.read.text}" is in {one.place}'
    return ""


WITHOUT_U = 0.05  # the uncertainty of another value that is reported without one, as a share of it
SMALL = 0.2  # a smaller share of the answer, without an uncertainty, may be the uncertainty of the answer


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


def _agree(rounded: Reported, other: Reported) -> bool:
    """Return whether two values with their uncertainties are the same but for rounding."""
    near = abs((rounded.value or 0.0) - (other.value or 0.0)) <= 0.501 * (
        rounded.step or 0.0
    )
    return near and abs((rounded.u or 0.0) - (other.u or 0.0)) <= 0.501 * (
        rounded.u_step or 0.0
    )


# --- the sentences of a file ---------------------------------------------------------------------------------


def lines_of(name: str, data: bytes) -> list[str]:
    """Read a file as lines of plain text; none if it cannot be read."""
    with suppress(*_UNREADABLE):
        return _read_lines(name, data)
    return []


_UNREADABLE = (
    GyroError,
    zipfile.BadZipFile,
    zlib.error,
    csv.Error,
    KeyError,
    OSError,
    RuntimeError,
    ValueError,
    AttributeError,
    TypeError,  # JSON that is not a notebook
)


def _read_lines(name: str, data: bytes) -> list[str]:
    """Read a file as lines of plain text; the cells of a table are separated by ``|``."""
    kind = ending(name)
    if kind in WORKBOOKS:
        unseen = visible.hidden_sheets(data)
        sheets = (
            sheet for title, sheet in sheet_rows(data).items() if title not in unseen
        )
        rows = (row[:30] for sheet in sheets for row in sheet[:_MOST_LINES])
        return [
            " | ".join("" if cell is None else str(cell) for cell in row)
            for row in rows
        ]
    if kind in _PACKED and zipfile.is_zipfile(io.BytesIO(data)):
        text = _packed_text(data, kind)
    else:
        text = readings.decode(data, readings.Faults(name))[0]
    if kind == ".json":
        text = re.sub(
            r'(?i)"(?!units?")(?:u|d|unc|err|std|sigma|delta)\w*":', "±", text
        )
        text = " ".join(re.sub(r'"units?":|[{}"]|,(?!\d)', " ", text).split())
    if kind == ".ipynb":
        text = "\n".join(_cell_texts(msgspec.json.decode(text)["cells"]))
    # In LaTeX, the rest of a line behind % is a comment; in a table, a line behind % is a remark.
    comment = r"(?<!\\)%.*" if kind == ".tex" else r"(?m)^[ \t]*%.*"
    for pattern in [*_STRUCK, *([comment] if kind not in TABLES else [])]:
        text = re.sub(pattern, lambda found: "\n" * found[0].count("\n"), text)
    text = text.partition(r"\end{document}")[0] if kind == ".tex" else text
    text = text if kind in TABLES else visible.latex_seen(text)
    text = visible.markdown_seen(text) if kind == ".md" else text
    is_page = kind in (".html", ".htm") or (
        kind != ".md" and re.search(r"(?i)</p>|<(?:br|sup)\b", text)
    )
    text = visible.page_seen(text) if is_page and kind not in _PACKED else text
    if kind in (".html", ".htm", ".docx", ".odt") or re.search(
        r"(?i)</p>|<(?:br|sup)\b", text
    ):
        for pattern, plain in _MARKUP:
            text = re.sub(pattern, plain, text)
        # Lines are counted as they are shown.
        shown = map(str.strip, html.unescape(text).split("\n"))
        text = "\n".join(filter(None, shown))
    lines = [visible.line_seen(line) for line in readings.lablog.split_lines(text)]
    return _in_cells(lines) if kind in TABLES else lines


def hidden_sheets_of(name: str, data: bytes) -> Collection[str]:
    """Return the hidden sheets of a workbook; none of another file, or of one that cannot be read."""
    if ending(name) in WORKBOOKS:
        with suppress(
            zipfile.BadZipFile, zlib.error, KeyError, OSError, RuntimeError, ValueError
        ):
            return visible.hidden_sheets(data)
    return ()


def _packed_text(data: bytes, kind: str) -> str:
    """Return the XML of a word processor, without the text in it that is hidden."""
    with (
        zipfile.ZipFile(io.BytesIO(data)) as archive,
        archive.open(_PACKED[kind]) as file,
    ):
        text = file.read(readings.MAX_BYTES).decode("utf-8", "replace")
    text = re.sub(r">\s+<", "><", text)
    return visible.page_seen(text) if kind == ".docx" else visible.open_text_seen(text)


def _cell_texts(cells: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Give the texts of a notebook: what its cells contain, and then what they printed."""
    printed: list[str] = []
    for cell in cells:
        hidden = (cell.get("metadata") or {}).get("jupyter") or {}
        source = "".join(cell["source"])
        if cell.get("cell_type") == "markdown":
            source = visible.markdown_seen(source)
        if cell.get("cell_type") != "raw" and not hidden.get("source_hidden"):
            yield source
        if not hidden.get("outputs_hidden"):
            printed += [
                "".join(["\n", *one.get("text", [])]) for one in cell.get("outputs", [])
            ]
    yield from printed


def _in_cells(table: Sequence[str], part: slice = slice(None)) -> list[str]:
    """Separate the cells of a table by ``|``; a line of prose, where a comma may be a decimal one, stays as it is."""
    sign, lines = (
        max("\t;,", key=lambda one: sum(line.count(one) > 1 for line in table)),
        table[part],
    )
    rows = (csv.reader([line[:_LONGEST_LINE]], delimiter=sign) for line in lines)
    return [
        line if re.search(SAYS["prose"], line) else " | ".join(*row)
        for line, row in zip(lines, rows, strict=True)
    ]


def partners_in(log: readings.Readings, reports: Iterable[tuple[str, bytes]]) -> str:
    """Return the partners that lines of the log name, and behind ``~`` all words of any text that may be a name."""
    lines = islice(re.finditer(SAYS["partner"], log.source_text, re.M), _MOST_NAMES)
    named = " & ".join(one[1].strip() for one in lines)[:_LONGEST_SENTENCE]
    called: dict[str, None] = {}
    # Text by text, so that a text that takes too long can be named.
    for text in chain(
        [log.source_text], ("\n".join(lines_of(name, data)) for name, data in reports)
    ):
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


def as_log(name: str, data: bytes) -> bytes:
    """Return a file as `read_log` reads it: a report of a word processor as its text, with ``|`` between cells."""
    return (
        "\n".join(lines_of(name, data)).encode() if ending(name) in _PACKED else b""
    ) or data


def _sentences(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Split lines into sentences without markup, each with the number of its line."""
    found, plain = [], [line[:_LONGEST_LINE] for line in lines[:_MOST_LINES]]
    for pattern, text in _PLAIN:
        plain = [line and re.sub(pattern, text, line) for line in plain]
    for number, line in enumerate(_with_titles(plain), 1):
        found += [
            (number, one)
            for one in re.split(
                r"(?<=[!?;])\s+(?=[^\W\d])|(?<=\.)\s+(?=[A-ZÀ-ÝΘ])", line
            )
        ]
    return [
        (number, one)
        for number, one in found
        if one.strip() and len(one) <= _LONGEST_SENTENCE
    ]


def _with_titles(lines: Sequence[str]) -> Iterator[str]:
    """Write the rows of a table as people write in lines: with ± in front of an uncertainty, and units behind."""
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
    """Return the second of two numbers with a unit, if it is an uncertainty: a small part of the first."""
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
    """Return the unit of I_zz, or the power of ten, that a name or title has in brackets: "Value (10⁻³ kg m²)"."""
    found = re.search(
        rf"(?:[\[(]|\bin\b|/)\s*({_POWER})?([^\[\]()|/]*)[\])]?[\s*_]*$", text
    )
    power, unit = found.groups("") if found else ("", "")
    return (
        power.lstrip(" x×·*") + unit
        if (power and not unit) or "inertia" in kinds_of(unit)
        else ""
    )


# --- the candidates ------------------------------------------------------------------------------------------

_UNIT = r"(?i)g[\s·*.⋅/-]{0,3}[cm]?m|n[\s·*.⋅]*m"
_OTHER_UNIT = r"[\d.,()±+/−⁻⁰-⁹\s×x*·^eE-]+?[kmc]{0,2}[gN](?:[\s·*⋅./]*(?:[ckm]?m|s|rad)(?:\^|\*\*)?[\d²³]?){1,3}"
_POWER = r"[x×·*\s]*10\s?\^?\s?[-−⁻]\s?[\d⁰¹²³⁴-⁹]+\s*"
_START = r"(?<![\w.,^(+\-−±/*×·])(?<![/*×·]\s)\(?[-+−]?\(?(?:\d|[.,]\d)"
_CUT = r"[,;.|]?\s+|(?<![.,;|])[.,;|]*$"
_OUTER_BARS = r"^\|(?:[\s|]+$)?|(?<![\s|])[\s|]+$"
_COUNT = r"(?<![\w.,])\d{1,2}(?=\s(?!percent|per cent|Prozent)(?i:[^\W\d]{3}|is\b|es\b|we\b))"
_TWO_NUMBERS = rf"(?<![\w.,^])\d\S*\s+(?:{SAYS['range']}\s+)?$"
_MARK = rf"(?i)(?:[=:≈|\t]|\bis\b)[\s=:|~≈]{{0,40}}(?:(?:about|ca\.?|approx\S{{0,20}}|{SAYS['value']})[\s=:|~≈]{{1,40}})?$"


def _candidates(name: str, lines: Sequence[str]) -> Iterator[_Candidate]:
    """Find the quantities of a file that may be the answer."""
    sentences = _sentences(lines)
    above = heading = ""
    for at, (number, sentence) in enumerate(sentences):
        end, before = 0, ""
        for start in (match.start() for match in re.finditer(_START, sentence)):
            if start < end:
                continue
            words = f"{above} | {sentence[:start]}" if not end else sentence[end:start]
            if (
                value := _value(sentence[start : start + _LONGEST_VALUE], words)
            ) is None:
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
            # A person must look at two numbers; without its own u, a value behind a word of u is an uncertainty.
            bad = (
                (_TWO_NUMBERS, before),
                (SAYS["other"], f"{before}\n{after}"),
                (SAYS["denied"], behind),
            )
            result, u = (
                re.search(SAYS["result"], f"{heading} | {before}") is not None,
                read.u is not None,
            )
            named = result or _names_inertia(before)
            if not any(re.search(*one) for one in bad) and (
                u or (named and not unsure)
            ):
                best = re.search(SAYS["final"], before) is not None
                rank = (
                    named,
                    u and read.fault != "wrong unit",
                    result and not re.search(r"\d", before),
                    best,
                )
                yield _Candidate(rank, f"{name}, line {number}", read)
            heading = f"{heading} | {before}"
        # A heading is above all values below it; titles of a table are in its rows already.
        heading = heading if end else sentence
        # The beginning of a sentence that goes on.
        parts = re.split(r"(?<![m^])\d|[.!?;](?:\s|$)|\)\s*$", sentence[end:])
        above = "" if "|" in sentence.strip(" |") else parts[-1]


def _cuts(text: str) -> Iterator[tuple[str, bool]]:
    """Give the beginnings of a text that may be a value, the longest first, and whether no other word follows."""
    for cut in reversed(list(re.finditer(_CUT, text))):
        value = text[: cut.start()].strip(" |_").rstrip(".,;")
        value = (
            value.removesuffix(")") if value.count(")") > value.count("(") else value
        )
        yield value, re.match(r"\s*(?:[,;.|(]|$)", text[cut.start() :]) is not None


def _value(text: str, before: str) -> tuple[str, int] | None:
    """Find a value at the beginning of a text, as `read_reported` reads it, and how long it is in the text.

    It has a unit of I_zz, or the name of I_zz directly in front, perhaps with a unit in brackets.
    """
    mark = re.search(_MARK, before)
    label = before[: mark.start()] if mark else ""
    unit = re.search(r"(?:[\[(]|\bin\b|/)\s*([^\[\]()|/]*)[\])]?[\s*_]*$", label)
    name = label[: unit.start()] if unit else label
    near = mark is not None and _names_inertia(name, near=True)
    for cut, whole in _cuts(text) if near or re.search(_UNIT, text) else ():
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


def _names_inertia(text: str, near: bool = False) -> bool:
    """Return whether words name I_zz, with `near` the last of them; a single letter must be next to the value."""
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
    """Add the uncertainty that follows an answer in words, such as "with an error of 0.1e-3 kg m^2"."""
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
    # The total uncertainty goes before its parts, and that of the mean before that of one run.
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
        # Without a unit of its own, the number may be of anything that is said in between.
        own = re.search(_UNIT, cut) and not any(name_roles(word)[0] for word in more)
        if (
            both.fault == read.fault
            and both.value == read.value
            and (own or (plain and (whole or "%" in cut)))
        ):
            return both if (both.u or 0) < abs(read.value or 0) else read
    return read
