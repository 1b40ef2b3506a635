"""``desk.csv``: decisions by hand, and the lines that are offered for it.

gyro reads the file and never writes it; with a fault in it, no line is used.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import chain, permutations, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, InputError, nearest
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Decision, Grade, added_up
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.rubric_file import UnfitError, unfit
from gyrodata.grading.submissions import Submission
from gyrodata.grading.yardsticks import grouped
from gyrodata.readings import Faults, decode, listing, read_reported
from gyrodata.readings.conversion import sheet_rows
from gyrodata.reporting.data import csv_cell, csv_lines

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades

DESK, TODO = "desk.csv", "desk-todo.csv"
COLUMNS = ("student", *Decision.__struct_fields__)
# a line of ``log`` with the name of a file; "log" may also be a criterion
CORRECTED = "corrected log"
FLAG, REGRADE, BETWEEN = "flag", "regrade", " + "
VERDICTS = ("partners", "copied", "invented", "cleared")
"""How a flag is settled, and what is written between its students."""


class Word(Struct, frozen=True):
    """What a person can decide: the parser and the page of the class use this list."""

    what: str
    kind: str  # of its value
    title: str
    is_several: bool = False  # a student may have several lines
    most: float = 0.0  # points

    @property
    def is_bare(self) -> bool:
        """Return whether the word needs no value."""
        return self.kind == "nothing"

    @property
    def how(self) -> str:
        """How to write a value."""
        if self.kind == "points":
            return f"write a number of points from 0 to {self.most:g}"
        return _HOW_TO_WRITE.get(self.kind, "")


WORDS = (
    Word("total", "points", "the total"),
    Word("bonus", "number", "points to add to the total, or to take off"),
    Word("reported", "inertia", "I_zz as the student reports it"),
    Word("station", "text", "the station of the log"),
    Word("partner", "student", "a student who handed in the same data", True),
    Word(FLAG, "verdict", "what a similarity of logs is"),
    Word("comment", "text", "a text for the student", True),
    Word(REGRADE, "text", "the answer to a request, which is under why", True),
    Word("hold", "nothing", "no points are shown yet"),
    Word("excuse", "nothing", "no points are needed"),
    Word("late", "points", "points to take off because of lateness"),
    Word(CORRECTED, "file", "the name of a corrected log"),
)
"""What a person can decide besides the points of criteria."""


def words_of(rubric: Rubric) -> dict[str, Word]:
    """Return all that can be decided about a student, by the word of the desk."""
    words = {}
    for criterion in rubric.criteria:
        key = criterion.id
        words[key] = Word(key, "points", criterion.title, most=criterion.points)
    for word in WORDS:
        words[word.what] = replace(word, most=rubric.points)
    return words


Known = Mapping[str, Collection[str]]  # keys of all students with a name, by its forms
STALE = (
    "resubmitted since"  # first words if a line was written for an earlier submission
)
UNGRADED = "no grade:"
_TO_GIVE = "points to give:"
_SEVERAL = tuple(word.what for word in WORDS if word.is_several)
SETTLING = (
    "total",
    "hold",
    "excuse",
)  # with one of these, nobody needs to look at the doubts of gyro


class Line(Struct, frozen=True):
    """A line of the file as a person wrote it."""

    people: tuple[str, ...]
    """The keys of its students."""
    what: str
    cells: Mapping[str, str]
    """By column, other columns too."""


def _nameless(line: Line) -> Line:
    """Return a line with the ids of its students, and without unknown columns."""
    known = {column: line.cells[column] for column in COLUMNS}
    return replace(line, cells=known | {"student": BETWEEN.join(line.people)})


class Desk(Struct, frozen=True):
    """The decisions in a class."""

    lines: Mapping[
        str, tuple[Decision, ...]
    ] = {}  # by student, in the order of the file
    left: Mapping[tuple[str, str], Decision] = {}
    """The lines with a name but no value, by student and what."""
    settled: Mapping[frozenset[str], str] = {}
    """How each flag is settled, by its students; one student alone: all flags of that
    student."""
    folder: Path = Path()  # folder of the file, and of corrected logs
    written: tuple[Line, ...] = ()  # all lines of the file
    requests: Mapping[str, list[str]] = {}
    """What students ask for and nobody has answered yet, by student."""

    def without_names(self) -> Desk:
        """Return the decisions with ids instead of names."""
        return replace(self, written=tuple(map(_nameless, self.written)))

    def value(self, student: str, what: str) -> str | None:
        """Return what was decided; None for nothing."""
        for decision in self.lines.get(student, ()):
            if decision.what == what:
                return decision.value
        return None

    def decides(self, student: str, what: str) -> bool:
        """Return whether a line decides something, or leaves it as it is."""
        is_left = (student, what) in self.left
        return is_left or self.value(student, what) is not None

    def open_requests(self) -> Iterator[Offer]:
        """Offer a line for the answer to each request."""
        for student, requests in self.requests.items():
            for why in requests:
                yield Offer(student, REGRADE, "", why, "regrade request")

    def waits(self, offer: Offer) -> bool:
        """Return whether an offered line is still to be decided."""
        is_decided = self.decides(offer.student, offer.what)
        return not offer.can_be_left or not is_decided

    @property
    def partners(self) -> list[frozenset[str]]:
        """Those who hand in the same data."""
        groups = []
        for student, decisions in self.lines.items():
            partners = [line.value for line in decisions if line.what == "partner"]
            groups += [frozenset((student, partner)) for partner in partners]
        for group, verdict in self.settled.items():
            if verdict == "partners" and len(group) > 1:
                groups.append(group)
        return groups

    def alike(self, flags: Iterable[Flag]) -> list[tuple[str, ...]]:
        """Return the students of each flag, unless their logs are alike by chance."""
        settled = self.settled
        students = [flag.students for flag in flags]
        return [some for some in students if settled.get(frozenset(some)) != "cleared"]

    def partners_of(self, student: str) -> set[str]:
        """Return the students with whom a student hands in the same data."""
        groups = (group for group in self.partners if student in group)
        return set[str]().union(*groups) - {student}

    def first_seen(
        self, grade: Grade, item: Submission, before: Mapping[str, str]
    ) -> dict[str, str]:
        """Return the digest of the submission for which each line was written.

        It is the digest of the first run with the line.
        """
        lines = self.lines.get(grade.student, ())
        now = dict(_seen_with(decision, grade, item) for decision in lines)
        if confirmation := self.left.get((grade.student, "total")):
            now |= dict([_confirmed_with(confirmation, grade, item)])
        return {key: before.get(key, digest) for key, digest in now.items()}

    def corrected(self, item: Submission) -> Submission:
        """Replace the log of a submission by the file that a person corrected.

        The original stays where it is.
        """
        name = self.value(item.student, CORRECTED)
        if name is None:
            return item
        path = Path(self.folder, name).resolve()
        return replace(item, log_name=str(path), log_file=path.name, problem=None)

    def applied(
        self, grade: Grade, item: Submission, first_seen: Mapping[str, str]
    ) -> Grade:
        """Apply the decisions to a grade; `first_seen` as the function of this name returned it."""
        lines = self.lines.get(grade.student, ())
        if not lines:
            return grade
        decisions = {decision.what: decision for decision in lines}
        about = f"{grade.digest}{lines!r}".encode("utf-8", "replace")
        digest = hashlib.sha256(about).hexdigest()
        stale = _stale(lines, grade, item, first_seen)
        if confirmation := self.left.get((grade.student, "total")):
            key, seen = _confirmed_with(confirmation, grade, item)
            if first_seen.get(key, seen) == seen:
                stale = []
        grade = _with_marks(grade, decisions)
        grade = _with_points(grade, decisions)
        is_settled = any(what in decisions for what in SETTLING)
        looks = () if is_settled else grade.look
        return replace(grade, by_hand=lines, look=(*looks, *stale), digest=digest)


def _stale(
    lines: Iterable[Decision],
    grade: Grade,
    item: Submission,
    first_seen: Mapping[str, str],
) -> list[str]:
    """Ask about each line that was written for an earlier submission."""
    stale = []
    for line in lines:
        key, digest = _seen_with(line, grade, item)
        is_about_points = bool(line.value) and line.what not in _SEVERAL
        if is_about_points and first_seen.get(key, digest) != digest:
            what = f"{line.what} {line.value} was set by hand"
            stale.append(
                f"{STALE} {what}: decide again; or confirm all decisions by a line "
                "total with your name, a new reason and no value"
            )
    return stale


def _with_marks(grade: Grade, decisions: Mapping[str, Decision]) -> Grade:
    """Give the points of criteria and lateness that a person decided."""
    marks = []
    for mark in grade.marks:
        if decision := decisions.get(mark.criterion):
            points = _points_in(decision)
            colon = ":" if decision.why else ""
            reason = f"given by hand{colon} {decision.signed_why}".rstrip()
            mark = replace(mark, points=points, reason=reason, detail={}, rule="")
        marks.append(mark)
    late = decisions.get("late")
    if tuple(marks) == grade.marks and late is None:
        return grade
    grade = replace(grade, marks=tuple(marks))
    if late is not None:
        looks = tuple(look for look in grade.look if look != grade.late_reason)
        deduction = read_number(late.value) or 0.0
        # The decision is shown with its reason, in the place of what the rule says.
        grade = replace(grade, look=looks, late_deduction=deduction, late_reason="")
    return added_up(grade)


def _points_in(decision: Decision) -> float:
    """Return the points of a decision, with two decimals."""
    return round(read_number(decision.value) or 0.0, 2)


def _with_points(grade: Grade, decisions: Mapping[str, Decision]) -> Grade:
    """Give the total and the bonus that a person decided, or no points."""
    if total := decisions.get("total"):
        points = _points_in(total)
        grade = replace(
            grade, status="graded", points=points, why=None, late_deduction=0.0
        )
    bonus = decisions.get("bonus")
    if bonus is not None and grade.points is not None:
        added = read_number(bonus.value) or 0.0
        points = max(0.0, round(grade.points + added, 2))
        grade = replace(grade, points=points)
    if "excuse" in decisions:
        return replace(grade, status="excused", why=None, points=None)
    if "hold" in decisions:
        return replace(grade, status="on hold", why=None, points=None)
    return grade


def _seen_with(decision: Decision, grade: Grade, item: Submission) -> tuple[str, str]:
    """Return the key of a line in the journal, and the digest of its subject.

    A corrected log replaces that of the student: a new one is seen by the files that the
    student handed in.
    """
    if decision.what == CORRECTED:
        return f"handed in: {decision!r}", item.original_digest
    return repr(decision), grade.digest


def _confirmed_with(line: Decision, grade: Grade, item: Submission) -> tuple[str, str]:
    """Return the key of a line that confirms all others, and what it was written for."""
    return f"confirmed: {line!r}", f"{grade.digest} {item.original_digest}"


NO_DESK = Desk()


def read_desk(path: Path, data: bytes, students: Known, rubric: Rubric) -> Desk:
    """Read the file; raise InputError with a fault for each line that cannot be used.

    `students` contains each name that a student may have in the file, by its forms as
    `forms_of` lists them, with the keys of all students with this name. A corrected log
    is in the folder of the file.
    """
    words = words_of(rubric)
    faults = list[Diagnostic]()
    number = 0
    read = _ReadDesk()
    try:
        for number, cells in read_list(data, path.name, "student", "what", "value"):
            row = dict.fromkeys(COLUMNS, "") | cells
            try:
                read.add(number, *_decision(row, words, students, path.parent), row)
            except UnfitError as error:
                place = {"file": path.name, "line": number}
                faults.append(replace(error.diagnostic, **place))
    except (csv.Error, LookupError, ValueError) as error:
        values = {"why": error.args[0], "columns": ",".join(COLUMNS)}
        faults = [Diagnostic.named("desk_not_read", path.name, number + 1, **values)]
    if faults:
        raise InputError(faults)
    decided = {}
    for student, mine in read.lines.items():
        decided[student] = tuple(decision for _, decision in mine.values())
    written = tuple(read.written)
    return Desk(decided, read.left, read.settled, path.parent, written, read.requests)


class _ReadDesk(Struct):
    """The decisions of the lines that are read."""

    lines: dict[str, dict[tuple[str, str], tuple[int, Decision]]] = {}
    """The number and the decision of each line, by student and by what is decided."""
    left: dict[tuple[str, str], Decision] = {}
    settled: dict[frozenset[str], str] = {}
    written: list[Line] = []
    requests: dict[str, list[str]] = {}

    def add(
        self,
        number: int,
        people: list[str],
        word: Word,
        decision: Decision,
        row: Mapping[str, str],
    ) -> None:
        """Add a line; raise UnfitError if an earlier one says something else."""
        self.written.append(Line(tuple(people), decision.what, row))
        if not decision.value and not word.is_bare:
            if decision.what == REGRADE:
                self.requests.setdefault(people[0], []).append(decision.why)
            elif decision.by:
                for student in people:
                    self.left[student, decision.what] = decision
            return
        if decision.what == FLAG:
            self.settled[frozenset(people)] = decision.value
        about = BETWEEN.join(people)
        if word.is_several:
            about = decision.value + decision.why
        for student in people:
            mine = self.lines.setdefault(student, {})
            at, before = mine.get((decision.what, about), (number, decision))
            if before.value != decision.value:
                values = {"what": decision.what, "who": row["student"]}
                both = {"here": decision.value, "before": before.value}
                raise unfit("desk_lines_contradict", line=at, **values, **both)
            mine[decision.what, about] = at, decision


def _decision(
    row: dict[str, str], words: Mapping[str, Word], known: Known, folder: Path
) -> tuple[list[str], Word, Decision]:
    """Read the students and the decision of a line, or raise UnfitError."""
    what = _word_of(row, words)
    value = row["value"]
    name = row["student"]
    is_group = what == FLAG and name.casefold() not in known
    names = name.split(BETWEEN) if is_group else [name]
    people = sorted({_student(person, known) for person in names})
    if len(people) < len(names):
        raise unfit("desk_student_twice", name=name[:60])
    word = words.get(what)
    if word is None:
        near = nearest(row["what"], (*words, "log"))
        raise unfit("desk_word_unknown", what=what, written=row["what"][:60], near=near)
    if value:
        if word.kind == "student":
            value = _student(value, known)
        how = _how_to_write(row, word, folder)
        if how:
            raise unfit("desk_value_unfit", what=what, value=value[:60], how=how)
        if word.kind == "verdict":
            value = value.casefold()
    return people, word, Decision(what, value, row["by"], row["why"])


_HOW_TO_WRITE = {
    "nothing": "leave the value empty; if it is not so, delete the line",
    "number": "write the points to add, such as 2",
    "file": "write the corrected log into the folder of the grades, and its name here",
    "verdict": "write partners, copied, invented or cleared; write who has decided it, under by",
    "inertia": "write value, uncertainty and unit: 4.4e-3 ± 0.1e-3 kg m^2",
}


def _how_to_write(row: Mapping[str, str], word: Word, folder: Path) -> str:
    """Say how to write a value of another kind than its word; "" if it can be used."""
    value = row["value"]
    is_fine = not word.is_bare
    if word.kind == "points":
        # "+2" means two points more.
        if word.what != "late" and value.startswith(("+", "-")):
            number = value[:60].removeprefix("+")
            return f"to change the total by this number, write bonus,{number}"
        is_fine = is_points(value, word.most)
    elif word.kind == "number":
        is_fine = is_points(value.lstrip("+-"), word.most)
    elif word.kind == "file":
        is_fine = (folder / value).is_file()
    elif word.kind == "verdict":
        is_fine = value.casefold() in VERDICTS and bool(row["by"])
    elif word.kind == "inertia":
        fault = read_reported("inertia", value).fault
        is_fine = fault not in ("unreadable", "wrong unit")
    return "" if is_fine else word.how


def _word_of(row: Mapping[str, str], words: Mapping[str, Word]) -> str:
    """Return what a line decides; "log" may be a criterion, or the file of a log."""
    written = row["what"]
    value = row["value"]
    what = written if written in words else written.casefold()
    if what != "log":
        return what
    is_number = not value or read_number(value) is not None
    return what if is_number and what in words else CORRECTED


def _student(name: str, known: Known) -> str:
    """Return the key of the only student with a name, or raise UnfitError."""
    keys = keys_of(name, known)
    if not keys:
        near = nearest(name, known, "write what grades.csv has under student")
        raise unfit("desk_student_unknown", name=name[:60], near=near)
    if len(keys) > 1 and name not in keys:
        some = " or ".join(keys[:5])
        values = {"count": len(keys), "keys": listing(keys), "some": some}
        raise unfit("desk_name_shared", name=name[:60], **values)
    return name if name in keys else keys[0]


def keys_of(name: str, known: Known) -> list[str]:
    """Return the keys of all students with a name, in any way of writing it.

    With known = {"doe, jane": ["7"], "doe jane": ["7"]}, "Jane Doe" gives ["7"]; an
    unknown name gives [].
    """
    for form in (*forms_of(name), *_user_names(name)):
        if form in known:
            return sorted(set(known[form]))
    return []


def forms_of(name: str) -> tuple[str, str]:
    """Return a name in small letters without accents, and its words in order.

    By the second form, two ways of writing are one person:

    >>> forms_of("Doe, Lucía")
    ('doe, lucia', 'doe lucia')
    >>> forms_of("Lucia Doe")
    ('lucia doe', 'doe lucia')
    """
    signs = unicodedata.normalize("NFD", name.casefold())
    plain = "".join(sign for sign in signs if not unicodedata.combining(sign))
    words = "".join(sign if sign.isalnum() else " " for sign in plain).split()
    return plain, " ".join(sorted(words))


def _user_names(name: str) -> list[str]:
    """List the names that a platform may make of a name: "doejane", "janedoe"."""
    words = forms_of(name)[1].split()
    if not 1 < len(words) < 5:
        return []
    return ["".join(some) for some in permutations(words)]


def read_number(text: str) -> float | None:
    """Read a number as platforms do: its last ``.`` or ``,`` is the decimal mark.

    "1,5" is 1.5, "1.234,5" is 1234.5, and "1,234" is 1.234; None for "ex", "1_5" and
    "1.3.2026", which is a date.
    """
    whole, mark, last = text.replace(",", ".").rpartition(".")
    decimal_mark = text[len(whole) : len(whole) + len(mark)]
    if mark and decimal_mark in text[: len(whole)]:
        return None
    try:
        number = float(f"{whole.replace('.', '')}{mark}{last}")
    except ValueError:
        return None
    return number if math.isfinite(number) and "_" not in text else None


def is_points(text: str, most: float) -> bool:
    """Return whether a text is a number of points."""
    points = read_number(text)
    return points is not None and 0 <= points <= most


_MARKED = r"(^|[;\n\t])'(?=[\s\"]*[=+\-@＝＋－＠])"
"""The mark in front of a text that a spreadsheet would run as a formula, as `csv_cell`
writes it."""


def read_list(
    data: bytes, name: str, *needed: str, lower: bool = True
) -> Iterator[tuple[int, dict[str, str]]]:
    """Read a table, a workbook or CSV as any spreadsheet saves it.

    The function gives the line of each row, and its cells by column.

    With `lower`, the names of the columns are in small letters. Raises csv.Error,
    LookupError or ValueError, with what is wrong, if it is not a table or lacks a
    column.
    """
    text = _text_of_table(data, name)
    delimiter = max(",;\t", key=text.partition("\n")[0].count)
    lines = io.StringIO(text, newline="")
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    head = [cell.strip() for cell in next(reader, [])]
    if lower:
        head = [cell.casefold() for cell in head]
    lacks = [f'"{column}"' for column in needed if column not in head]
    if lacks and text.strip():
        raise LookupError(f"there is no column {' and '.join(lacks)}")
    number = reader.line_num + 1
    for cells in reader:
        row = [re.sub(_MARKED, r"\1", cell.strip()) for cell in cells]
        if any(row):
            named = dict(zip_longest(head, row, fillvalue=""))
            named.pop("", None)
            yield number, named
        number = reader.line_num + 1


def _text_of_table(data: bytes, name: str) -> str:
    """Return the text of a table; the first sheet of a workbook as CSV."""
    if not data.startswith(b"PK"):
        return decode(data, Faults(name))[0]
    rows = next(iter(sheet_rows(data).values()), [])
    return csv_lines(map(csv_cell, row) for row in rows)


# --- the lines that wait for a person: ``desk-todo.csv`` ---


LONGEST = 300  # characters of a text in a table or on the page of the class


def short(text: str) -> str:
    """Return a text, or its beginning if it is very long."""
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST - 1]}…"


class Offer(Struct, frozen=True):
    """A line for the desk, ready to be copied."""

    student: str
    what: str
    value: str  # "": to be filled in
    why: str
    reason: str  # the part of `why` that other lines share
    flag: Flag | None = None  # the flag that it is about

    @property
    def cells(self) -> list[str]:
        """The columns of the desk, without a name under ``by``."""
        people = BETWEEN.join(self.people)
        why = short(self.why)
        return [csv_cell(cell) for cell in (people, self.what, self.value, "", why)]

    @property
    def can_be_left(self) -> bool:
        """Return whether a line without a value settles it.

        Such a line gives nobody a grade or an answer, and a flag is settled by its
        students.
        """
        return not (
            self.flag
            or self.what == REGRADE
            or self.gives_points
            or self.reason.startswith(UNGRADED)
            or self.why.startswith(STALE)
        )

    @property
    def gives_points(self) -> bool:
        """Return whether it asks for points that gyro cannot give."""
        return self.reason.startswith(_TO_GIVE)

    @property
    def people(self) -> tuple[str, ...]:
        """All students that the line is about."""
        if self.flag is None:
            return (self.student,)
        return self.flag.students


def in_general(why: str) -> str:
    """Return the part of a reason that other students share.

    It consists of the words before the details, without numbers: of "the reported I_zz
    is 9.1 u from the runs, and no …", "the reported I_zz is … u from the runs".
    """
    if why.startswith(STALE):
        return f"{STALE} something was set by hand"
    if why.startswith("the file "):
        why = why.partition(": ")[2] or why
    without_numbers = re.sub(r"\b\d[\d.e+-]*", "…", why)
    return re.split(r"[,;:(]", without_numbers, maxsplit=1)[0].strip()


def find_offers(
    class_grades: ClassGrades, by_hand: Iterable[tuple[str, str]] = ()
) -> list[Offer]:
    """List the lines that wait for a person, without those that the desk decides.

    Lines of one reason together.

    `by_hand`: Students with other points in the gradebook, and these.
    """
    different = dict.fromkeys(_offers(class_grades, by_hand))
    offers = filter(class_grades.desk.waits, different)
    by_reason = grouped((offer.reason, offer) for offer in offers)
    return list(chain.from_iterable(by_reason.values()))


def _offers(
    class_grades: ClassGrades, by_hand: Iterable[tuple[str, str]]
) -> Iterator[Offer]:
    """Give the lines, the most urgent ones first."""
    grades = class_grades.grades
    for student, value in by_hand:
        yield _other_points(student, value, class_grades.rubric.points)
    yield from class_grades.desk.open_requests()
    for grade in grades:
        if grade.why is not None:
            has_answer = not grade.own or grade.reported_inertia is not None
            what = "total" if has_answer else "reported"
            reason = f"{UNGRADED} {in_general(grade.why)}"
            yield Offer(grade.student, what, "", grade.why, reason)
    yield from chain.from_iterable(map(_looks, grades))
    yield from _open_flags(class_grades)
    for grade in grades:
        if grade.status in ("so far", "not graded"):
            yield from _open_marks(grade)


def _looks(grade: Grade) -> Iterator[Offer]:
    """Offer a line for each doubt about a grade."""
    for look in grade.look:
        what = "late" if look == grade.late_reason else "total"
        yield Offer(grade.student, what, "", look, in_general(look))


def _other_points(student: str, value: str, most: float) -> Offer:
    """Offer to take over the points that a person has set in the gradebook."""
    why = "is in the gradebook"
    if not is_points(value, most):
        # The desk would refuse them.
        why = f"{value} {why}, and is not a number of points from 0 to {most:g}"
        value = ""
    return Offer(student, "total", value, why, "other points are in the gradebook")


def _open_marks(grade: Grade) -> Iterator[Offer]:
    """Offer the points of each criterion that wait for a person."""
    for mark in grade.marks:
        if mark.waits:
            reason = f"{_TO_GIVE} {mark.title}"
            yield Offer(grade.student, mark.criterion, "", mark.reason, reason)


def _open_flags(class_grades: ClassGrades) -> Iterator[Offer]:
    """Offer each flag that is not settled for all its students."""
    desk = class_grades.desk
    graded = set()
    for what in SETTLING:
        names = class_grades.names
        graded |= {key for key in names if desk.value(key, what) is not None}
    alone = (group for group in desk.settled if len(group) == 1)
    single = set[str]().union(*alone)
    lenders = _lenders(class_grades.grades)
    for flag in class_grades.flags:
        students = set(flag.students) - single
        settled = students <= graded or _is_decided(flag, desk, lenders)
        if not flag.previous:
            settled |= any(students <= {*group} for group in class_grades.groups)
        if not settled:
            words = f"flag: {flag.kind}"
            why = f"{words}: {flag.evidence}"
            yield Offer(flag.students[0], FLAG, "", why, words, flag)


def _lenders(grades: Iterable[Grade]) -> dict[str, str]:
    """Return whose log each student without an own log is graded on."""
    return {grade.student: grade.log_of for grade in grades if grade.log_of}


def _is_decided(flag: Flag, desk: Desk, lenders: Mapping[str, str]) -> bool:
    """Return whether a line is about the students of a flag.

    A student who was lent a log of this flag adds nothing to it.
    """
    students = frozenset(flag.students)
    lent = {key for key in students if lenders.get(key) in students}
    return students in desk.settled or students - lent in desk.settled


def todo_csv(
    offers: Iterable[Offer], names: Mapping[str, str], files: Mapping[str, str]
) -> str:
    """Write the lines, sorted by student.

    Each line contains the names of the students and the files to look into.
    """
    rows: list[Iterable[str]] = [(*COLUMNS, "name", "look into")]
    for offer in sorted(offers, key=_place_in_todo):
        named = BETWEEN.join(names[key] for key in offer.people)
        handed_in = BETWEEN.join(files[key] for key in offer.people)
        cells = [csv_cell(short(text)) for text in (named, handed_in)]
        rows.append([*offer.cells, *cells])
    return csv_lines(rows)


def _place_in_todo(offer: Offer) -> tuple[str, ...]:
    """Return what sorts a line: by student, then by what is decided."""
    return offer.student, offer.what, offer.value, offer.why
