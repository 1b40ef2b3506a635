"""The students of a class: names, sections, stations and partners."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.grading.grade import Grade
from gyrodata.grading.ledger import Known, forms_of, keys_of, read_list
from gyrodata.grading.submissions import Submission, Submissions
from gyrodata.grading.submissions.documents import SAYS
from gyrodata.grading.submissions.names import different
from gyrodata.grading.yardsticks import grouped, station_key
from gyrodata.readings import listing
from gyrodata.readings.names import words_of

_MAIL = ("email", "email address")
IDS = (
    "id",
    "student",
    "identifier",
    "sis user id",
    "sis login id",
    "username",
    "student id",
    "id number",
    *_MAIL,
)
NAMES = ("name", "full name", "student name", "student")
TEST_STUDENT = "Student, Test"
"""The name in a gradebook of Canvas with which an instructor tries the course."""


class Person(NamedTuple):
    """One row."""

    student: str  # key of the submission; without a submission, the first id of the row
    name: str
    section: str
    station: str
    partners: str  # as written
    ids: tuple[str, ...]  # all ids and addresses of the row
    grader: str = ""

    @property
    def words(self) -> str:
        """The words of the name in order: "doe jane"."""
        return forms_of(self.name)[1]


NOBODY = Person("", "", "", "", "", ())


class Roster(Struct, frozen=True):
    """All rows."""

    people: Mapping[str, Person] = {}  # students with a submission, by key
    absent: tuple[Person, ...] = ()  # students without one
    unclear: Mapping[
        str, str
    ] = {}  # why a person must find the row of a submission, by its key

    def with_submissions(self, students: Iterable[str]) -> Roster:
        """Return the roster in which absent students have a submission."""
        absent = {absentee.student: absentee for absentee in self.absent}
        moved = {student: absent.pop(student) for student in {*students}}
        people = {**self.people, **moved}
        return replace(self, people=people, absent=tuple(absent.values()))

    def without_names(self) -> Roster:
        """Return the roster with ids instead of names."""
        nameless = [person._replace(name=person.student) for person in self.absent]
        return replace(self, absent=tuple(nameless))

    def named(self, grade: Grade, station: str | None) -> Grade:
        """Add the student's name and section to a grade.

        A `station` of the desk goes before that of log and roster.
        """
        person = self.people.get(grade.student, NOBODY)
        decided = station_key(station or "")
        station = decided or grade.station or station_key(person.station) or None
        name = person.name or grade.name
        return replace(grade, name=name, section=person.section, station=station)

    def who_is_meant(self, items: Iterable[Submission]) -> dict[str, list[str]]:
        """Return the keys of all students with a name, an id or an address.

        They are by the `forms_of` the name: those of "Doe, Jane" with the key "7" are
        {"doe, jane": ["7"], "doe jane": ["7"], "7": ["7"]}. A key means only its own
        student.
        """
        people = (*self.people.values(), *self.absent)
        called = [(person.student, (person.name, *person.ids)) for person in people]
        called += [(item.student, (item.name, *item.ids.values())) for item in items]
        pairs = [
            (student, name) for student, names in called for name in filter(None, names)
        ]
        # Also without the key, which a name has if others have the same name.
        pairs += [
            (student, name.removesuffix(f" ({student})")) for student, name in pairs
        ]
        meant = grouped(
            (form, student) for student, name in pairs for form in forms_of(name)
        )
        return meant | grouped((student.casefold(), student) for student, _ in called)


EVERYBODY = Roster()

_BETWEEN_NAMES = r"(?:(?<!\s)\s+)?(?:[;/&+\n]|\b(?:and|und|et|y)\b)\s*"
_ONESELF = r"(?i)(?:me|myself|I|ich|moi|yo|io|ik|ja|eu|jag)?"


def students_of(text: str, meant: Known) -> tuple[set[str], list[str]]:
    """Find the students that a text names, as "Doe, Jane" or "Jane Doe and Max Roe".

    Also return the names of nobody, or of several students: if "7" is Jane Doe, the
    text "Jane Doe & Max" gives ({"7"}, ["Max"]), and "alone" gives (set(), []).
    """
    if re.fullmatch(SAYS["alone"], text):
        return set(), []
    keys = {name: keys_of(name, meant) for name in _names_in(text, meant)}
    students = {people[0] for people in keys.values() if len(people) == 1}
    unclear = [name for name, people in keys.items() if len(people) != 1]
    if students:
        # "Eva Berg, we share the data" names one student.
        unclear = [name for name in unclear if not name[:1].islower()]
    return students, unclear


def _names_in(text: str, meant: Known) -> Iterator[str]:
    """Yield the names in a text, in which a comma may be a part of a name."""
    for part in re.split(_BETWEEN_NAMES, text.strip()):
        is_name = "," not in part or keys_of(part, meant)
        for name in [part] if is_name else part.split(","):
            if not re.fullmatch(_ONESELF, name.strip()):
                yield name.strip()


class Partners(NamedTuple):
    """The groups, by the roster and by the texts of the students."""

    groups: Sequence[frozenset[str]]
    """Students that the roster joins, or that name each other: they are not flagged."""
    lines: Mapping[str, Collection[str]]
    """The students that lines such as "partner: Jane Doe" name, by student."""
    looks: Mapping[str, str]
    """What a person should look at, by student: names of nobody, or of several."""

    def of(self, student: str) -> set[str]:
        """Return all partners of a student, also those that one side names."""
        partners = set(self.lines.get(student, ()))
        partners |= {other for other, named in self.lines.items() if student in named}
        for group in self.groups:
            if student in group:
                partners |= group
        return partners - {student}

    def lends(self, lender: str, student: str) -> bool:
        """Return whether the roster or the lender says that a student is a partner."""
        if student in self.lines.get(lender, ()):
            return True
        return any({lender, student} <= group for group in self.groups)


def find_partners(texts: Mapping[str, str], roster: Roster, meant: Known) -> Partners:
    """Find the partners that the roster names, or the texts of the students.

    `texts`: What `partners_in` found, by student.
    """
    groups = list[frozenset[str]]()
    looks = dict(roster.unclear)
    lines: dict[str, set[str]] = {}
    named: dict[str, set[str]] = {}
    for student, text in texts.items():
        person = roster.people.get(student, NOBODY)
        listed, unlisted = students_of(person.partners, meant)
        own, _, others = text.partition(" ~ ")
        lines[student], unknown = students_of(own, meant)
        # Other words may be a name as well, such as "Moment of Inertia".
        named[student] = lines[student] | students_of(others, meant)[0]
        if listed:
            groups.append(frozenset((student, *listed)))
        if unknown := [*unlisted, *unknown]:
            names = listing(unknown, 3)
            look = f"gyro cannot find the partner, {names}: see the log and the roster"
            looks[student] = look
    mutual = set()
    for student, some in named.items():
        for other in some - {student}:
            if student in named.get(other, ()):
                mutual.add(frozenset((student, other)))
    groups += sorted(mutual, key=sorted)
    return Partners(groups, lines, looks)


def partners_by_log(items: Iterable[Submission]) -> list[frozenset[str]]:
    """Return the students who are graded on one log."""
    by_log = grouped((item.log_of or item.student, item.student) for item in items)
    students = {key: {key, *some} for key, some in by_log.items()}
    return [frozenset(some) for some in students.values() if len(some) > 1]


def read_roster(data: bytes, name: str, submissions: Submissions) -> Roster:
    """Read a table with columns of `IDS`, `NAMES`, section, station and partner.

    Raises InputError.
    """
    by_id = _students_by_id(submissions)
    people: dict[str, Person] = {}
    others = []
    for person in filter(None, map(_person, _read_rows(data, name))):
        ids = map(str.casefold, person.ids)
        known = [by_id[identifier] for identifier in ids if identifier in by_id]
        if known:
            people.setdefault(known[0], person._replace(student=known[0]))
        else:
            others.append(person)
    named = _find_by_name(others, people, submissions)
    people |= named.people
    absent = sorted(named.absent)
    names = {key: person.name for key, person in people.items()}
    shown = different(names, [person.name for person in absent])
    people = {key: member._replace(name=shown[key]) for key, member in people.items()}
    return Roster(people, tuple(absent), named.unclear)


def _read_rows(data: bytes, name: str) -> list[dict[str, str]]:
    """Read a table that has a column of ids or names."""
    why = "has no column that says who is who"
    try:
        rows = [cells for _, cells in read_list(data, name)]
        if rows and not rows[0].keys().isdisjoint((*IDS, *NAMES)):
            return rows
    except (csv.Error, LookupError, ValueError) as error:
        why = f"cannot be read: {error}"
    raise InputError.named("roster_not_read", name, name=name, why=why)


def _person(cells: Mapping[str, str]) -> Person | None:
    """Read one row; None for a row of no student."""
    names = [cells[column] for column in NAMES if cells.get(column)]
    both = f"{cells.get('first name', '')} {cells.get('last name', '')}".strip()
    name = next(iter([*names, both]))
    # Moodle writes "Participant N" for N.
    written = [cells[column] for column in IDS if cells.get(column)]
    ids = [re.sub(r"^\D+ (\d+)$", r"\1", text) for text in written]
    if not ids:
        ids = [name]
    if ids == [""] or _is_of_platform(cells, name):
        return None
    section = cells.get("section", "")
    station = cells.get("station", "")
    partner = cells.get("partner", "")
    grader = cells.get("grader") or cells.get("ta", "")
    return Person(ids[0], name, section, station, partner, tuple(ids), grader)


def _is_of_platform(cells: Mapping[str, str], name: str) -> bool:
    """Return whether a row of Canvas is of no student.

    The points possible have no number, and the test student none of the school.
    """
    is_test = name == TEST_STUDENT and cells.get("sis user id") == ""
    return cells.get("id") == "" or is_test


def _students_by_id(submissions: Submissions) -> dict[str, str]:
    """Return the key of each student by ids in small letters.

    "doe_jane_12345" contains an id. A key means its own student first of all.
    """
    by_id: dict[str, str] = {}
    for item in submissions.items:
        for known in (*item.ids.values(), *item.members_of_group):
            by_id[known.casefold()] = item.student
        for part in words_of(item.student.casefold()):
            if re.search(r"\d{4}", part):
                by_id[part] = item.student
    for item in submissions.items:
        by_id[item.student.casefold()] = item.student
    return by_id


def _find_by_name(
    rows: list[Person], by_id: Mapping[str, Person], submissions: Submissions
) -> Roster:
    """Find the students of rows by their names.

    A name only means a student whose id is in no other row, here `by_id`.
    """
    meant = EVERYBODY.who_is_meant(submissions.items)
    rows_of = grouped((person.words, person.student) for person in rows)
    people: dict[str, Person] = {}
    absent = []
    unclear: dict[str, str] = {}
    for person in rows:
        called = (set(keys_of(known, meant)) for known in (*person.ids, person.name))
        free = (keys - by_id.keys() - people.keys() for keys in called)
        students = next(filter(None, free), set())
        rivals = rows_of[person.words]
        if not students:
            absent.append(person)
        elif len(students) == len(rivals) == 1:
            (student,) = students
            people[student] = person._replace(student=student)
        for student in students - people.keys():
            names = listing(sorted(rivals))
            unclear[student] = (
                f"gyro cannot tell whose row of the roster this is: {names} have the "
                f'same name; add a column "identifier", with {student} in the right row'
            )
    return Roster(people, tuple(absent), unclear)
