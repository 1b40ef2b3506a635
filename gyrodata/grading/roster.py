"""The students of a class: names, sections, stations and partners, from a gradebook or a table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.diagnostics import ROSTER_CANNOT_BE_READ
from gyrodata.errors import InputError
from gyrodata.grading.exports.gradebooks import read_sheet
from gyrodata.grading.grade import Grade
from gyrodata.grading.submissions import Submissions
from gyrodata.grading.yardsticks import station_key

IDS = ("id", "student", "identifier", "sis user id", "sis login id", "username", "email", "email address")
NAMES = ("name", "full name", "student")


class Person(NamedTuple):
    """One row."""

    student: str  # key of the submission; for one who handed in nothing, the first id of the row
    name: str
    section: str
    station: str
    partners: tuple[str, ...]  # keys


class Roster(Struct, frozen=True):
    """All rows."""

    people: Mapping[str, Person] = field(default_factory=dict)  # those who handed in, by key
    absent: tuple[Person, ...] = ()  # those who did not

    def named(self, grade: Grade) -> Grade:
        """Give a grade its student's name and section, and the station where the log says none."""
        person = self.people.get(grade.student)
        if person is None:
            return grade
        station = grade.station or station_key(person.station) or None
        return replace(grade, name=person.name or grade.name, section=person.section, station=station)

    def who_is_meant(self, submissions: Submissions) -> dict[str, set[str]]:
        """Give the keys of all who may be called by a name, by the name in small letters.

        A key means its own student only. One who handed in nothing may have the name of one who did.
        """
        people = (*self.people.values(), *self.absent)
        called = [(one.student, name) for one in people for name in (one.name, _alone(one.name, one.student)) if name]
        for item in submissions.items:
            names = (item.name, _alone(item.name, item.student), *item.ids.values())
            called += [(item.student, name) for name in names]
        keys: dict[str, set[str]] = {}
        for item in submissions.items:
            keys.setdefault(item.student.casefold(), set()).add(item.student)
        meant: dict[str, set[str]] = {}
        for student, name in called:
            meant.setdefault(name.casefold(), set()).add(student)
        here = set().union(*keys.values())
        return {name: students for name, students in meant.items() if students & here} | keys

    @property
    def partners(self) -> list[frozenset[str]]:
        """Those who hand in the same data."""
        return [frozenset((key, *person.partners)) for key, person in self.people.items() if person.partners]


def read_roster(data: bytes, name: str, submissions: Submissions) -> Roster:
    """Read a table whose first row names its columns, of `IDS`, `NAMES`, section, station and partner."""
    rows = [[cell.strip() for cell in row] for row in read_sheet(data, name).rows]
    head = [title.casefold() for title in rows[0]]
    if not any(title in IDS for title in head):
        hint = "give a gradebook, or a CSV whose first line is student,name,section,station,partner"
        raise InputError.of(ROSTER_CANNOT_BE_READ, f'"{name}" has no column that says who is who', hint, name)
    known = {alias.casefold(): key for alias, key in submissions.aliases.items()}
    known |= {member.casefold(): item.student for item in submissions.items for member in item.members_of_group}
    people: dict[str, Person] = {}
    absent: list[Person] = []
    for row in rows[1:]:
        cells = dict(zip(head, row, strict=False))
        ids = [_bare(cells[column]) for column in IDS if cells.get(column)]
        # Canvas's rows of points possible and of test students have a title and no number.
        if not ids or ("id" in head and not cells.get("id")):
            continue
        # A platform may write "Adler, Nina" as "adlernina".
        tried = (known.get(form) for one in ids for form in (one.casefold(), re.sub(r"\W", "", one.casefold())))
        key = next(filter(None, tried), None)
        partners = (known.get(_bare(one).casefold()) for one in re.split("[,;]", cells.get("partner", "")))
        person = Person(
            key or ids[0],
            next((cells[column] for column in NAMES if cells.get(column)), None)
            or " ".join(filter(None, (cells.get("first name"), cells.get("last name")))),
            cells.get("section", ""),
            cells.get("station", ""),
            tuple(one for one in partners if one),
        )
        if key is None:
            absent.append(person)
        else:
            people.setdefault(key, person)
    counts = Counter(one.name for one in (*people.values(), *absent))
    # Two with one name are told apart by what each is known by.
    parted = {
        key: one._replace(name=f"{one.name} ({key})") if one.name and counts[one.name] > 1 else one
        for key, one in people.items()
    }
    return Roster(parted, tuple(sorted(absent)))


def _alone(name: str, student: str) -> str:
    """Take the key from a name that has it, because others have the same name."""
    return name.removesuffix(f" ({student})")


def _bare(text: str) -> str:
    """Take N of Moodle's "Participant N"."""
    return re.sub(r"^\D+ (\d+)$", r"\1", text.strip())
