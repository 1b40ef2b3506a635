"""``desk.csv``: decisions by hand. gyro reads it and never writes it; with a fault in it, no line is used."""

from __future__ import annotations

import csv
import difflib
import hashlib
import io
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import zip_longest

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic, InputError
from gyrodata.grading.criteria import Mark
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Decision, Grade, added_up, two_decimals
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.yardsticks import station_key
from gyrodata.readings import listing, read_reported
from gyrodata.reporting.data import csv_cell, csv_lines
from gyrodata.toml_table import UnfitError, nearest

DESK, TODO = "desk.csv", "desk-todo.csv"
COLUMNS = ("student", *Decision.__struct_fields__)
WORDS = ("total", "reported", "station", "partner", "flag", "comment", "hold", "excuse")
"""What may be decided besides the points of a criterion."""

FLAG, VERDICTS, BETWEEN = "flag", ("partners", "copied", "cleared"), " + "
"""How a flag is settled, and what stands between the students of one."""

SEVERAL = ("partner", "comment")  # a student may have several lines of these
BARE = ("hold", "excuse")  # these need no value
STALE = "resubmitted since"  # the first words if a line was written for another submission
SETTLING = ("total", "hold", "excuse")  # nobody need look at what gyro doubted where one of these is given


class Desk(Struct, frozen=True):
    """The decisions in a class."""

    lines: Mapping[str, tuple[Decision, ...]]  # by student, in the order of the file
    left: frozenset[tuple[str, str]] = frozenset()  # student and what of the lines without a value: left as gyro has it
    unfilled: frozenset[tuple[str, str, str]] = frozenset()
    """Student, what, and the reason in general of the lines with neither a value nor a name."""
    settled: Mapping[frozenset[str], str] = {}
    """How each line settles a flag, by the students in it; one student alone: all flags of that student."""

    def value(self, student: str, what: str) -> str | None:
        """Give what was decided of one thing; None for nothing."""
        return next((one.value for one in self.lines.get(student, ()) if one.what == what), None)

    def decides(self, student: str, what: str) -> bool:
        """Tell whether a line speaks of one thing."""
        return (student, what) in self.left or any(one.what == what for one in self.lines.get(student, ()))

    def empty(self, offer: Offer) -> bool:
        """Tell whether a line speaks of what is offered, and has no value."""
        return (offer.student, offer.what) in self.left or self._copied(offer)

    def waits(self, offer: Offer) -> bool:
        """Tell whether what is offered is still to be decided: a line that was only copied decides nothing."""
        return offer.why.startswith(STALE) or self._copied(offer) or not self.decides(offer.student, offer.what)

    def _copied(self, offer: Offer) -> bool:
        return (offer.student, offer.what, in_general(offer.why)) in self.unfilled

    @property
    def partners(self) -> list[frozenset[str]]:
        """Those who hand in the same data."""
        found = ((student, one) for student, lines in self.lines.items() for one in lines if one.what == "partner")
        declared = [group for group, verdict in self.settled.items() if verdict == VERDICTS[0] and len(group) > 1]
        return [*(frozenset((student, one.value)) for student, one in found), *declared]

    def first_seen(self, grade: Grade, before: Mapping[str, str]) -> dict[str, str]:
        """Say of each line which submission it was written for, by the line: the one of the first run that saw it."""
        return {key: before.get(key, grade.digest) for key in map(repr, self.lines.get(grade.student, ()))}

    def with_station(self, grade: Grade) -> Grade:
        """Put a grade where the desk says that the student was."""
        station = self.value(grade.student, "station")
        return grade if station is None else replace(grade, station=station_key(station))

    def applied(self, grade: Grade, seen: Mapping[str, str]) -> Grade:
        """Give a settled grade what was decided; `seen` as `first_seen` has it."""
        lines = self.lines.get(grade.student, ())
        if not lines:
            return grade
        given = {one.what: one for one in lines}
        stale = [
            f"{STALE} {one.what} {one.value} was set by hand: change its line in {DESK} to confirm it"
            for one in lines
            if one.what not in (*SEVERAL, *BARE) and seen.get(repr(one), grade.digest) != grade.digest
        ]
        marks = tuple(_given(mark, given[mark.criterion]) if mark.criterion in given else mark for mark in grade.marks)
        if marks != grade.marks:
            grade = added_up(replace(grade, marks=marks))
        if total := given.get("total"):
            points = round(read_number(total.value) or 0.0, 2)
            grade = replace(grade, status="graded", why=None, points=points, late_deduction=0.0)
        if "hold" in given:
            grade = replace(grade, status="on hold", why=None, points=None)
        if "excuse" in given:
            grade = replace(grade, status="excused", why=None, points=None)
        looks = () if any(what in given for what in SETTLING) else grade.look
        digest = hashlib.sha256(f"{grade.digest}{lines!r}".encode("utf-8", "replace")).hexdigest()
        return replace(grade, by_hand=lines, look=(*looks, *stale), digest=digest)


NO_DESK = Desk({})


def _given(mark: Mark, decision: Decision) -> Mark:
    """Make a mark of points given by hand."""
    reason = f"given by hand: {decision.told}" if decision.told else "given by hand"
    return replace(mark, points=round(read_number(decision.value) or 0.0, 2), reason=reason, detail={}, rule="")


def read_desk(data: bytes, students: Mapping[str, Collection[str]], rubric: Rubric) -> Desk:
    """Read the file; raise with a fault for each line that cannot be used.

    `students`: Every name by which a student may be called there, in small letters, with the keys of all who have it.
    """
    points = {one.id: one.points for one in rubric.criteria} | {"total": rubric.points}
    faults: list[Diagnostic] = []
    lines: dict[str, dict[tuple[str, str], tuple[int, Decision]]] = {}
    left: set[tuple[str, str]] = set()
    unfilled: set[tuple[str, str, str]] = set()
    settled: dict[frozenset[str], str] = {}
    number = 0
    try:
        text = data.decode("utf-8-sig", "replace")
        if "\ufffd" in text:
            number = text.partition("\ufffd")[0].count("\n")
            raise LookupError("it is no text in UTF-8")
        for number, cells in csv_table(text, *COLUMNS[:3]) if text.strip() else ():
            row = dict.fromkeys(COLUMNS, "") | {column.casefold(): cell for column, cell in cells.items()}
            try:
                one_name = row["what"].casefold() != FLAG or row["student"].casefold() in students
                names = [row["student"]] if one_name else row["student"].split(BETWEEN)
                people = sorted({_student(name, students) for name in names})
                what = _what(row["what"], points)
                if not row["value"] and what not in BARE:
                    if what != FLAG:
                        left.add((people[0], what))
                    if not row["by"]:
                        unfilled.add((people[0], what, in_general(row["why"])))
                    continue
                value = _value(what, row["value"], points, students)
                if what == FLAG and not row["by"]:
                    hint = "write who has decided it, under by"
                    raise UnfitError("a flag is settled by a person", hint, diagnostics.DESK_LINE_CANNOT_BE_USED)
                settled |= {frozenset(people): value} if what == FLAG else {}
                key = what, BETWEEN.join(people) if what == FLAG else value if what in SEVERAL else ""
                for student in people:
                    mine = lines.setdefault(student, {})
                    at, before = mine.get(key, (number, None))
                    if before is not None and before.value != value:
                        message = f'{what} of "{row["student"]}" is {value} here and {before.value} in line {at}'
                        hint = "keep the line that holds, and remove the other"
                        raise UnfitError(message, hint, diagnostics.DESK_LINES_CONTRADICT)
                    mine[key] = at, Decision(what, value, row["by"], row["why"])
            except UnfitError as error:
                faults.append(Diagnostic.of(error.code, str(error), error.hint, DESK, number))
    except (csv.Error, LookupError) as error:
        hint = f'the first line is {",".join(COLUMNS)}; save it as "CSV UTF-8"'
        faults = [
            Diagnostic.of(diagnostics.DESK_CANNOT_BE_READ, f"cannot be read: {error.args[0]}", hint, DESK, number + 1)
        ]
    if faults:
        raise InputError(faults)
    decided = {student: tuple(one for _, one in mine.values()) for student, mine in lines.items()}
    return Desk(decided, frozenset(left), frozenset(unfilled), settled)


def _student(name: str, known: Mapping[str, Collection[str]]) -> str:
    if name.casefold() not in known:
        close = difflib.get_close_matches(name.casefold(), known, n=1)
        keys = sorted(known[close[0]]) if close else []
        hint = f"did you mean {' or '.join(keys)}?" if keys else "write what grades.csv has under student"
        raise UnfitError(f'"{name[:60]}" is nobody in this class', hint, diagnostics.DESK_STUDENT_UNKNOWN)
    keys = sorted(known[name.casefold()])
    if len(keys) > 1 and name not in keys:
        message = f'{len(keys)} students are called "{name[:60]}": {listing(keys, 5)}'
        raise UnfitError(message, f"write {' or '.join(keys[:5])} instead of the name", diagnostics.DESK_NAME_SHARED)
    return name if name in keys else keys[0]


def _what(word: str, points: Mapping[str, float]) -> str:
    if word in points or word.casefold() in WORDS:
        return word if word in points else word.casefold()
    message = f'"{word[:60]}" is no criterion of the rubric, and nothing else that can be decided'
    raise UnfitError(message, nearest(word, (*points, *WORDS[1:])), diagnostics.DESK_LINE_CANNOT_BE_USED)


def _value(what: str, value: str, points: Mapping[str, float], known: Mapping[str, Collection[str]]) -> str:
    """Give a value as it is kept."""
    if what in points and not _is_points(value, points[what]):
        message = f'{what} = "{value[:60]}" is no number of points from 0 to {points[what]:g}'
        raise UnfitError(message, f"write a number, such as {points[what] / 2:g}", diagnostics.DESK_LINE_CANNOT_BE_USED)
    read = read_reported("inertia", value)
    if what == "reported" and read.fault in ("unreadable", "wrong unit"):
        message = f'reported = "{value[:60]}" cannot be read: {read.problem or "it is no number"}'
        hint = "write value, uncertainty and unit: 4.4e-3 ± 0.1e-3 kg m^2"
        raise UnfitError(message, hint, diagnostics.DESK_LINE_CANNOT_BE_USED)
    if what == FLAG and value.casefold() not in VERDICTS:
        message = f'flag = "{value[:60]}" settles nothing'
        raise UnfitError(
            message, f"write {', '.join(VERDICTS[:-1])} or {VERDICTS[-1]}", diagnostics.DESK_LINE_CANNOT_BE_USED
        )
    if what == FLAG:
        return value.casefold()
    return _student(value, known) if what == "partner" else "" if what in BARE else value


def read_number(text: str) -> float | None:
    """Read a number as platforms do."""
    *whole, last = re.split("[.,]", text)
    try:
        return float(f"{''.join(whole)}.{last}" if whole else last)
    except ValueError:
        return None


def _is_points(text: str, most: float) -> bool:
    """Tell whether a cell is a number of points that may be given."""
    points = read_number(text)
    return points is not None and 0 <= points <= most


# --- tables as CSV ------------------------------------------------------------------------------------------


def csv_table(text: str, *needed: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Read a table that a spreadsheet may have saved in its own way: the line of each row, and its cells by column.

    csv.Error or LookupError, with what is wrong, where it is none or lacks a column.
    """
    top = text.partition("\n")[0]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=top.count), skipinitialspace=True)
    head = [cell.strip() for cell in next(reader, [])]
    if lacks := [f'"{column}"' for column in needed if column not in map(str.casefold, head)]:
        raise LookupError(f"there is no column {' and '.join(lacks)}")
    number = reader.line_num + 1
    for cells in reader:
        # A ' stands before what would be a formula.
        row = [cell.strip().removeprefix("'") for cell in cells]
        if any(row):
            yield number, {column: cell for column, cell in zip_longest(head, row, fillvalue="") if column}
        number = reader.line_num + 1


# --- what waits for a person: ``desk-todo.csv`` -------------------------------------------------------------


class Offer(Struct, frozen=True):
    """A line for the desk, ready to be copied."""

    student: str
    what: str
    value: str  # "": to be filled in
    why: str
    reason: str  # what it has in common with others, in words
    flag: Flag | None = None  # what it is about

    @property
    def cells(self) -> list[str]:
        """The columns of the desk, who decides left open."""
        return [csv_cell(one) for one in (BETWEEN.join(self.people), self.what, self.value, "", self.why)]

    @property
    def people(self) -> tuple[str, ...]:
        """All whom it is about."""
        return self.flag.students if self.flag is not None else (self.student,)


def offer_points(student: str, what: str, value: str, most: float, where: str, reason: str) -> Offer:
    """Offer points that stand elsewhere; those that the desk would refuse are only told."""
    if _is_points(value, most):
        return Offer(student, what, value, where, reason)
    return Offer(student, what, "", f"{value} {where}, and is no number of points from 0 to {most:g}", reason)


def in_general(why: str) -> str:
    """Give what a reason has in common with those of other students: what stands before its numbers and particulars."""
    if why.startswith(STALE):
        return f"{STALE} something was set by hand"
    return re.split(r"[,;:(]", re.sub(r"\b\d[\d.e+-]*", "…", why), maxsplit=1)[0].strip()


def todo_csv(offers: Iterable[Offer], names: Mapping[str, str], files: Mapping[str, str]) -> str:
    """Write the lines by student, with the name of each and the files to look into behind them."""
    ordered = sorted(offers, key=lambda one: (one.student, one.what, one.value, one.why))
    rows = (
        [*one.cells, *(csv_cell(BETWEEN.join(told[key] for key in one.people)) for told in (names, files))]
        for one in ordered
    )
    return csv_lines([(*COLUMNS, "name", "look into"), *rows])


def same_value(one: str, other: str) -> bool:
    """Tell whether two cells say the same, as numbers where they are: a spreadsheet writes 20.00 as 20."""
    numbers = read_number(one), read_number(other)
    return one.strip() == other.strip() if None in numbers else two_decimals(numbers[0]) == two_decimals(numbers[1])
