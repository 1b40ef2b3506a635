"""Find the answer in the log and the texts of a student.

All values that may be I_zz are found by `candidates`, and the best named value is used.
Nothing is guessed: of two different values that are equally good, neither is taken.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import PurePosixPath
from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import readings
from gyrodata.base.errors import Diagnostic
from gyrodata.grading.submissions import visible
from gyrodata.grading.submissions.archives import PDF, TABLES, ending
from gyrodata.grading.submissions.candidates import (
    Candidate,
    Rank,
    find_candidates,
    version_in,
)
from gyrodata.grading.submissions.documents import (
    MOST_LINES,
    NO_TEXT,
    SAYS,
    Document,
    in_cells,
    read_document,
    without_marks,
)
from gyrodata.readings import Reported

_MOST_NAMES, _LONGEST_NAMES = 100, 1000


class Answers(Struct, frozen=True):
    """The value that a student reports, from any of the files."""

    inertia: Reported | None = None  # I_zz [kg*m^2]; None if nothing is reported
    diagnostics: tuple[Diagnostic, ...] = ()  # notes on how it was read
    file: str = ""  # name of the file with I_zz
    questions: tuple[str, ...] = ()  # to a person, about the answer
    unread: tuple[Diagnostic, ...] = ()  # each a file that cannot be read
    of_gyro: bool = False  # whether I_zz is only in a report that gyro analyze wrote


def read_answers(
    log: readings.Readings | None,
    reports: Iterable[Document | tuple[str, bytes]] = (),
) -> Answers:
    """Find the answer: the line of the log for it, else the best value in the texts.

    `reports` are the other texts, or their names and bytes. Of a text with "I_zz =
    4.4 g m^2" and another with "I_zz = 4.9 g m^2", neither is taken: the fault is
    `GIVEN_TWICE`. Never raises: a value that cannot be read has a fault.
    """
    documents = _documents(reports)
    if log is not None:
        documents.append(Document(log.name, _lines_of(log)))
    texts = [find_candidates(document) for document in documents]
    cuts = tuple(text.cut for text in texts if text.cut)
    values = [*chain.from_iterable(text.values for text in texts)]
    possible = [candidate for candidate in values if not candidate.compared]
    stated = _stated_in(log, possible)
    chosen = stated or _best_beside(log, possible)
    unread = _unread(documents, has_answer=chosen is not None)
    if chosen is None:
        return Answers(questions=cuts, unread=unread)
    notes = []
    if stated is None:
        place = {"place": chosen.place, "text": chosen.read.text}
        notes.append(Diagnostic.named("answer_elsewhere", **place))
    doubts = [*_doubts(chosen, possible), *_lost_powers(chosen)]
    questions = *cuts, *doubts, *_disagreements(chosen, values)
    return Answers(
        chosen.read, tuple(notes), chosen.file, questions, unread, chosen.of_gyro
    )


def _documents(reports: Iterable[Document | tuple[str, bytes]]) -> list[Document]:
    """Read the texts that are not read yet."""
    return [
        report if isinstance(report, Document) else read_document(*report)
        for report in reports
    ]


def _lines_of(log: readings.Readings) -> list[str]:
    """Return the lines of a log that contain words, as a person sees them."""
    lines = in_cells(readings.lablog.split_lines(log.source_text))
    visible_lines = [without_marks(visible.of_line(line)) for line in lines]
    return [
        line.strip('#%" ') if re.search(_WORD, line) else "" for line in visible_lines
    ]


_WORD = r"[^\W\d_]{2}"


def _stated_in(
    log: readings.Readings | None, values: Iterable[Candidate]
) -> Candidate | None:
    """Return the value that a log reports, with what the lines below it say of it."""
    if log is None or "inertia" not in log.reported:
        return None
    read = log.reported["inertia"]
    rank = Rank(True, True, True)
    if read.u is None or read.fault:
        for value in values:
            is_there = (value.file, value.read.line) == (log.name, read.line)
            if is_there and value.read.value == read.value:
                return replace(value, rank=rank)
    return Candidate(rank, f"{log.name}, line {read.line}", read)


def _unread(documents: Iterable[Document], has_answer: bool) -> tuple[Diagnostic, ...]:
    """Name the files that cannot be read; a PDF of pictures may be a plot."""
    return tuple(
        Diagnostic.named(
            "file_of_class_unreadable",
            document.name,
            name=document.name,
            why=document.problem,
        )
        for document in documents
        if document.problem and not (has_answer and document.problem == NO_TEXT)
    )


def _best_beside(
    log: readings.Readings | None, candidates: Sequence[Candidate]
) -> Candidate | None:
    """Return the best candidate; one in the log only if no other text has one."""
    beside = [each for each in candidates if log is None or each.file != log.name]
    if not candidates:
        return None
    return _best(beside or candidates)


def _best(candidates: Sequence[Candidate]) -> Candidate:
    """Return the best candidate; without its value if another is equally good."""
    best = max(map(_goodness, candidates))
    equal = _of_latest_file([each for each in candidates if _goodness(each) == best])
    # The same answer may be written with more digits.
    chosen = max(equal, key=lambda candidate: candidate.read.step or 0.0)
    rivals = [each for each in equal if not _agree(chosen.read, each.read)]
    return _without_value(chosen, rivals[0]) if rivals else chosen


def _goodness(candidate: Candidate) -> tuple[bool, Rank]:
    """Return what decides.

    A draft or a report of gyro is an answer only if there is no other one.
    """
    is_last = _is_draft(candidate) or candidate.of_gyro
    return candidate.rank.is_named and not is_last, candidate.rank


GIVEN_TWICE: Final = "given twice"


def _without_value(chosen: Candidate, rival: Candidate) -> Candidate:
    """Return a candidate without its value, because there is another one."""
    read = chosen.read
    first, second = (f'"{each.read.text}" in {each.place}' for each in (chosen, rival))
    problem = f"two values are found: {first} and {second}"
    read = Reported(
        "inertia", read.text, fault=GIVEN_TWICE, problem=problem, line=read.line
    )
    return replace(chosen, read=read)


def _of_latest_file(equal: list[Candidate]) -> list[Candidate]:
    """Keep the candidates of the latest version, if all are versions of one file."""
    versions = [version_of(candidate.file) for candidate in equal]
    if len({base for _, base in versions}) > 1:
        return equal
    latest = max(versions)
    return [candidate for candidate in equal if version_of(candidate.file) == latest]


def _is_draft(candidate: Candidate) -> bool:
    (rank, _), _ = version_of(candidate.file)
    return rank < 0


def _doubts(chosen: Candidate, candidates: Iterable[Candidate]) -> Iterator[str]:
    """Ask about an answer that a person may not see, unless it is elsewhere too.

    Also ask about one with a statistical and another uncertainty.
    """
    shown = [each.read for each in candidates if each.rank.is_named and not each.doubt]
    where = f'the answer "{chosen.read.text}" in {chosen.place}'
    if chosen.doubt and not any(_agree(chosen.read, read) for read in shown):
        yield f"{where} may be hidden; look whether the file shows it"
    if chosen.of_gyro:
        what = f'"{chosen.read.text}" in {chosen.place}'
        yield f"only a report of gyro analyze contains an answer: {what}"
    if chosen.has_second_u:
        yield f"{where} may have another uncertainty behind it: give the total one"


def _lost_powers(chosen: Candidate) -> Iterator[str]:
    """Ask about a unit in a PDF that may have lost its superscript: "kg cm"."""
    if chosen.read.fault == "wrong unit" and ending(chosen.file) == PDF:
        words = f'"{chosen.read.text}" in {chosen.file} may have lost a superscript'
        yield f"{words}; look into it"


def _disagreements(chosen: Candidate, candidates: Iterable[Candidate]) -> Iterator[str]:
    """Describe another named value that differs by more than both uncertainties."""
    read = chosen.read
    for candidate in candidates:
        if candidate.file == chosen.file:
            # The text may call it an earlier one, and the answer a later one.
            is_earlier = candidate.rank.version < 0 < chosen.rank.version
        else:
            # A draft or an earlier log may have another answer.
            is_earlier = _is_draft(candidate) or ending(candidate.file) in TABLES
            is_earlier |= candidate.of_gyro
        is_rival = candidate.rank.is_named and not is_earlier
        if is_rival and read.fault != GIVEN_TWICE and _differ(read, candidate.read):
            used = f'two answers: "{read.text}" in {chosen.file} is used'
            yield f'{used}, and "{candidate.read.text}" is in {candidate.place}'
            return


# the uncertainty of another value that is reported without one, as a share of it
WITHOUT_U = 0.05
# a smaller share of the answer, without an uncertainty, may be the uncertainty of the
# answer
SMALL = 0.2


def _differ(read: Reported, other: Reported) -> bool:
    """Return whether two values differ by more than their uncertainties allow."""
    value = read.value or 0.0
    another = other.value or 0.0
    if other.u is None and abs(another) < SMALL * abs(value):
        return False
    u = read.u or 0.0
    another_u = other.u
    if another_u is None:
        another_u = WITHOUT_U * abs(another)
    return abs(value - another) > u + another_u


_COPY = re.compile(r"(?P<base>.+?)(?:-| ?\()(?P<number>\d{1,2})\)?")
"""Canvas writes ``lab-1.csv`` for a second ``lab.csv``; browsers and Blackboard write
``lab(1).csv``."""


def version_of(name: str) -> tuple[tuple[int, int], str]:
    """Return the version in a file name, and the name without it.

    A version is its rank by `version_in`, and the number of the copy: "lab_v3.csv" is
    ((2, 0), "lab"), "lab(1).csv" is ((0, 1), "lab"), "lab_old.csv" is ((-1, 0), "lab").
    """
    stem = PurePosixPath(name.lower()).stem
    copy = _COPY.fullmatch(stem)
    number = int(copy["number"]) if copy else 0
    stem = copy["base"] if copy else stem
    return (version_in(stem), number), re.sub(SAYS["version"], "", stem)


def _agree(rounded: Reported, other: Reported) -> bool:
    """Return whether two values with uncertainties are equal but for rounding."""
    apart = abs((rounded.value or 0.0) - (other.value or 0.0))
    u_apart = abs((rounded.u or 0.0) - (other.u or 0.0))
    is_near = apart <= 0.501 * (rounded.step or 0.0)
    return is_near and u_apart <= 0.501 * (rounded.u_step or 0.0)


# --- partners ---


def partners_in(
    log: readings.Readings | None, reports: Iterable[Document | tuple[str, bytes]]
) -> str:
    """Return the partners that lines of the log or of the reports name.

    Behind ``~`` are all words of any text that may be a name.
    """
    texts = ["\n".join(document.lines[:MOST_LINES]) for document in _documents(reports)]
    if log is not None:
        texts.insert(0, log.source_text)
    names = []
    called = dict[str, None]()
    for text in texts:
        lines_of_text = re.finditer(SAYS["partner"], text, re.M)
        names += [match[1].strip() for match in islice(lines_of_text, _MOST_NAMES)]
        called |= dict.fromkeys(islice(_called_in(text), _MOST_NAMES))
    lines = " & ".join(names[:_MOST_NAMES])[:_LONGEST_NAMES]
    words = " & ".join([*called][:_MOST_NAMES])
    return f"{lines} ~ {words}" if words else lines


def _called_in(text: str) -> Iterator[str]:
    """Yield all words that may be a name: "Team Ann Lee" contains "Ann Lee"."""
    for match in re.finditer(SAYS["called"], text):
        words = re.split("[ ,]+", match[0][:_LONGEST_NAMES])
        for size in (2, 3, 4):
            for at in range(len(words) - size + 1):
                yield " ".join(words[at : at + size])
