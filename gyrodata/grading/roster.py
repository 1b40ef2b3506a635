"""The students of a class: names, sections, stations and partners, from a gradebook or a table."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import ROSTER_CANNOT_BE_READ
from gyrodata.errors import InputError
from gyrodata.grading.grade import Grade
from gyrodata.grading.ledger import read_list
from gyrodata.grading.submissions import Submissions
from gyrodata.grading.yardsticks import station_key

IDS = ("id", "student", "identifier", "sis user id", "sis login id", "username", "email", "email address")
NAMES = ("name", "full name", "student")


class Person(NamedTuple):
    """One row."""

    student: str  # key of the submission; without a submission, the first id of the row
    name: str
    section: str
    station: str
    partners: tuple[str, ...]  # keys


class Roster(Struct, frozen=True):
    """All rows."""

    people: Mapping[str, Person] = {}  # students with a submission, by key
    absent: tuple[Person, ...] = ()  # students without one

    def named(self, grade: Grade) -> Grade:
        """Add the name and section of the student to a grade, and the station if the log states none."""
        person = self.people.get(grade.student)
        if person is None:
            return grade
        station = grade.station or station_key(person.station) or None
        return replace(grade, name=person.name or grade.name, section=person.section, station=station)

    def who_is_meant(self, submissions: Submissions) -> dict[str, set[str]]:
        """Return the keys of all students with a name, by the name in small letters.

        A key means only its own student. A student without a submission may have the name of one with a submission.
        """
        called: list[tuple[str, tuple[str, ...]]]
        called = [(one.student, (one.name,)) for one in (*self.people.values(), *self.absent)]
        called += [(item.student, (item.name, *item.ids.values())) for item in submissions.items]
        meant: dict[str, set[str]] = {}
        for student, names in called:
            # Without the key, which a name has if others have the same name.
            for name in {*names, *(one.removesuffix(f" ({student})") for one in names)} - {""}:
                meant.setdefault(name.casefold(), set()).add(student)
        keys: dict[str, set[str]] = {}
        for item in submissions.items:
            keys.setdefault(item.student.casefold(), set()).add(item.student)
        here = {item.student for item in submissions.items}
        return {name: students for name, students in meant.items() if students & here} | keys

    @property
    def partners(self) -> list[frozenset[str]]:
        """Those who hand in the same data."""
        return [frozenset((key, *person.partners)) for key, person in self.people.items() if person.partners]


def read_roster(data: bytes, name: str, submissions: Submissions) -> Roster:
    """Read a table with columns of `IDS`, `NAMES`, section, station and partner. Raises InputError."""
    hint = "give a gradebook, or a CSV whose first line is student,name,section,station,partner"
    try:
        rows = [cells for _, cells in read_list(data, name)]
    except csv.Error as error:
        raise InputError.of(ROSTER_CANNOT_BE_READ, f'"{name}" cannot be read: {error}', hint, name) from None
    if not rows or not set(IDS) & rows[0].keys():
        raise InputError.of(ROSTER_CANNOT_BE_READ, f'"{name}" has no column that says who is who', hint, name)
    known: dict[str, str] = {}
    for item in submissions.items:
        known |= dict.fromkeys(map(str.casefold, (item.name, *item.ids.values(), *item.members_of_group)), item.student)
    known |= {item.student.casefold(): item.student for item in submissions.items}
    people: dict[str, Person] = {}
    absent: list[Person] = []
    for cells in rows:
        # Moodle writes "Participant N" for N.
        ids = [re.sub(r"^\D+ (\d+)$", r"\1", cells[column]) for column in IDS if cells.get(column)]
        # Canvas's rows of points possible and of test students have a title and no number.
        if not ids or ("id" in cells and not cells["id"]):
            continue
        # A platform may write "Adler, Nina" as "adlernina".
        tried = (known.get(form) for one in ids for form in (one.casefold(), re.sub(r"\W", "", one.casefold())))
        key = next(filter(None, tried), None)
        partners = (known.get(one.strip().casefold()) for one in re.split("[,;]", cells.get("partner", "")))
        called = next((cells[column] for column in NAMES if cells.get(column)), "")
        called = called or f"{cells.get('first name', '')} {cells.get('last name', '')}".strip()
        about = called, cells.get("section", ""), cells.get("station", ""), tuple(filter(None, partners))
        if key is None:
            absent.append(Person(ids[0], *about))
        else:
            people.setdefault(key, Person(key, *about))
    counts = Counter(one.name for one in (*people.values(), *absent))
    # Students with one name are shown with their keys.
    for key, one in people.items():
        if one.name and counts[one.name] > 1:
            people[key] = one._replace(name=f"{one.name} ({key})")
    return Roster(people, tuple(sorted(absent)))
