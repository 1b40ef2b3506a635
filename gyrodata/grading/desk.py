"""The desk of whoever grades: what is written into the folder of the grades, and what a run would change in it."""

from __future__ import annotations

import errno
import hashlib
import struct
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from itertools import combinations
from pathlib import Path, PurePosixPath

from msgspec import Struct

from gyrodata.diagnostics import DESK_CANNOT_BE_READ, GRADES_FOLDER_CANNOT_BE_WRITTEN
from gyrodata.disk import file_name, files_like, new_file, telling, write_whole
from gyrodata.errors import InputError
from gyrodata.grading import ledger
from gyrodata.grading.classroom import ClassGrades, figure_path
from gyrodata.grading.exports import TOTAL, Change, compare_tables, flags_csv, read_table
from gyrodata.grading.exports.class_json import grades_document
from gyrodata.grading.exports.class_page import class_page
from gyrodata.grading.exports.gradebooks import Filled, Ours, fill_book
from gyrodata.grading.grade import Grade, not_graded
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission, Submissions

FIGURES = "figures"
TABLE, PUBLISHED = "grades.csv", "published"


class Gradebooks(Struct, frozen=True):
    """The gradebooks of platforms that are filled."""

    given: Mapping[str, tuple[bytes, str]]  # by platform: the sheet, and its name
    assignment: str | None = None  # column, where a sheet has several

    def fill(
        self, grades: Collection[Grade], ids: Mapping[str, Mapping[str, str]], ours: Ours | None = None
    ) -> dict[str, Filled]:
        """Fill them; by the name of the file to be written. `ours`: As `fill_book` has it."""
        if not self.given:
            return {}
        from gyrodata.grading.feedback import feedback_comment

        comments = {grade.student: feedback_comment(grade) for grade in grades}
        filled = {}
        for lms, (data, name) in self.given.items():
            sheet = fill_book(
                lms, data, name, grades, assignment=self.assignment, comments=comments, ids=ids, ours=ours
            )
            # Blackboard's sheet with tabs ends in .xls.
            filled[f"{lms}.xls" if name.lower().endswith(".xls") else f"{lms}.csv"] = sheet
        return filled

    def try_out(self, submissions: Submissions, rubric: Rubric) -> None:
        """See that they can be filled, before a class is graded for them; raise as `fill` does."""
        first = submissions.items[0]
        self.fill((not_graded(first, rubric, "not yet"),), {first.student: first.ids})


def changes_in(folder: Path, found: ClassGrades) -> tuple[Change, ...] | None:
    """Say what changes in the table of grades of a folder; None where what is there is no such table."""
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        there = folder / TABLE
        return compare_tables(_text(there), found.table) if there.is_file() else ()


def find_desk(folder: Path, students: Mapping[str, Collection[str]], rubric: Rubric) -> ledger.Desk:
    """Read the desk of a folder; raise with all its faults. `students`: As `read_desk` has it."""
    try:
        return ledger.read_desk((folder / ledger.DESK).read_bytes(), students, rubric)
    except (FileNotFoundError, NotADirectoryError):
        return ledger.NO_DESK
    except OSError as error:
        message = f'"{folder / ledger.DESK}" cannot be read: {error.strerror or error}'
        raise InputError.of(DESK_CANNOT_BE_READ, message, "", ledger.DESK) from None


# --- the earlier tables in the folder: ``grades-DIGEST.csv`` for each that was written here, and
# ``grades-DIGEST-by-hand-DIGEST.csv`` for one that somebody changed --------------------------------------------


def _published(folder: Path, *digests: str) -> Path:
    return folder / PUBLISHED / f"grades-{'-by-hand-'.join(digests)}.csv"


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]


def _text(path: Path) -> str:
    return path.read_bytes().decode("utf-8-sig", "replace")


def _keep_table(folder: Path, table: bytes) -> None:
    """Keep the table that is there, where somebody changed it, and the one that is to be written."""
    newest, kept = folder / PUBLISHED / "newest.txt", {_published(folder, _digest(table)): table}
    there = (folder / TABLE).read_bytes() if (folder / TABLE).is_file() else None
    if there is not None and not _published(folder, _digest(there)).is_file():
        base = newest.read_text("ascii", "replace").strip() if newest.is_file() else ""
        kept = {_published(folder, base or "0", _digest(there)): there} | kept
    for path, data in (kept | {newest: f"{_digest(table)}\n".encode()}).items():
        if not path.is_file() or path.read_bytes() != data:
            write_whole(path, [data], private=True, sync=True)


def totals_from_here(folder: Path, desk: ledger.Desk, students: Iterable[str]) -> Ours:
    """Give the totals that each student ever had from here; None for one whose total the desk speaks of."""
    tables = [read_table(_text(path)) or {} for path in files_like(folder / PUBLISHED, "grades-????????????.csv")]
    return {
        student: None
        if desk.decides(student, TOTAL)
        else {number for table in tables if (number := table.get(student, {}).get(TOTAL))}
        for student in students
    }


def _set_in_tables(found: ClassGrades, folder: Path) -> Iterator[ledger.Offer]:
    """Give what somebody changed in a table, and neither the desk nor the new table has."""
    now = read_table(found.table) or {}
    most = {TOTAL: found.rubric.points} | {one.id: one.points for one in found.rubric.criteria}
    for path in files_like(folder / PUBLISHED, "grades-*-by-hand-*.csv"):
        base = _published(folder, path.name.split("-")[1])
        if not base.is_file():
            continue
        old = read_table(_text(base)) or {}
        for student, row in (read_table(_text(path)) or {}).items():
            before, after = old.get(student, {}), now.get(student, {})
            for column, value in row.items():
                told = (before.get(column, ""), after.get(column, ""))
                where, reason = f"{column} was set by hand in {TABLE}", f"{TABLE} was changed by hand"
                if not value or student not in found.names or any(ledger.same_value(value, one) for one in told):
                    continue
                if column in most:
                    yield ledger.offer_points(student, column, value, most[column], where, reason)
                elif column not in before:
                    yield ledger.Offer(student, "comment", value, where, reason)


# --- what waits for a person, and what is written -----------------------------------------------------------


def _find_offers(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> list[ledger.Offer]:
    """List what waits for a person, without what the desk speaks of; what has one reason stands together."""
    offers = list(_set_in_tables(found, folder))
    for sheet in filled.values():
        for student, value in sheet.by_hand:
            where, reason = "stands in the gradebook", "other points stand in the gradebook"
            offers.append(ledger.offer_points(student, TOTAL, value, found.rubric.points, where, reason))
    together: dict[str, dict[ledger.Offer, None]] = {}
    for offer in (*filter(found.desk.waits, offers), *waiting_lines(found)):
        together.setdefault(offer.reason, {})[offer] = None
    return [offer for same in together.values() for offer in same]


_MISSING, _UNJUDGED, _UNREAD = "no I_zz is reported", "a part cannot be judged", "the log cannot be used"


def waiting_lines(found: ClassGrades) -> Iterator[ledger.Offer]:
    """Offer what waits in the grades and flags themselves, without what the desk speaks of."""
    desk = found.desk
    for grade in found.grades:
        # An empty line gives nobody a grade.
        if grade.why is not None:
            missing = grade.own and grade.reported_inertia is None
            reason = f"no grade: {_MISSING if missing else _UNJUDGED if grade.own else _UNREAD}"
            yield ledger.Offer(grade.student, "reported" if missing else TOTAL, "", grade.why, reason)
    for grade in found.grades:
        for look in grade.look:
            offer = ledger.Offer(grade.student, TOTAL, "", look, ledger.in_general(look))
            if desk.waits(offer):
                yield offer
    graded = {
        student for student in found.names if any(desk.value(student, what) is not None for what in ledger.SETTLING)
    }
    alone = frozenset[str]().union(*(group for group in desk.settled if len(group) == 1))
    known = [*desk.partners, *found.roster.partners, *desk.settled]
    for flag in found.flags:
        # Each pair of a flag is settled, or where it is about other logs too, each student.
        if flag.previous or len(flag.students) == 1:
            settled = graded | alone | (set(flag.students) if frozenset(flag.students) in desk.settled else set())
            waits = not settled.issuperset(flag.students)
        else:
            waits = not all(
                graded.issuperset(pair) or alone.intersection(pair) or any(group.issuperset(pair) for group in known)
                for pair in combinations(flag.students, 2)
            )
        if waits:
            yield ledger.Offer(
                flag.students[0], ledger.FLAG, "", f"flag: {flag.kind}: {flag.evidence}", f"flag: {flag.kind}", flag
            )
    for grade in found.grades:
        for mark in grade.marks:
            if mark.waits and grade.status in ("so far", "not graded"):
                offer = ledger.Offer(grade.student, mark.criterion, "", mark.reason, f"points to give: {mark.title}")
                if desk.waits(offer):
                    yield offer


def _files_of(item: Submission) -> str:
    """Return the names of a student's other files, or of the log if there is only the log."""
    others = [name for name in item.members if name != item.log_name] or item.members
    return ", ".join(PurePosixPath(name).name for name in others)


def write_results(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> int:
    """Write everything but the feedback, a table that somebody changed kept; count the lines that wait for a person."""
    names = feedback_names(found)
    files = {item.student: _files_of(item) for item in found.submissions.items}
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        _keep_table(folder, found.table.encode("utf-8", "replace"))
        offers = _find_offers(found, folder, filled)
        texts: dict[str, Iterable[str]] = {
            ledger.TODO: [ledger.todo_csv(offers, found.names, files)],
            TABLE: [found.table],
            "flags.csv": [flags_csv(found.flags)],
            "class.html": [class_page(found, lambda student: f"{FOLDER}/{names[student]}.html", offers, files, folder)],
            "grades.json": grades_document(found),
        }
        for name, parts in texts.items():
            data = (part.encode("utf-8", "replace") for part in parts)
            write_whole(folder / name, data, private=True, sync=name == TABLE)
        for name, sheet in filled.items():
            write_whole(folder / name, [sheet.data], private=True)
    return len(offers)


# --- the feedback of a class, in files named so that the platform takes them, and a zip of all --------------


FOLDER = "feedback"
ARCHIVE = "feedback.zip"
ENDINGS = (".html", ".md")


_FOR_ALL = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EROFS, errno.EMFILE, errno.ENFILE, errno.ENOMEM)
"""What the system says of no single name: a disk that is full or broken, and the like."""


def _write_page(
    folder: Path, before: Mapping[str, int] | None, grade: Grade, stem: str, drawn: Mapping[str, tuple[Path, str]]
) -> Iterator[str]:
    from gyrodata.grading.feedback import feedback_html, feedback_markdown

    figures = {name: (path.read_bytes(), words) for name, (path, words) in drawn.items()}
    for ending, text in zip(ENDINGS, (feedback_html(grade, figures), feedback_markdown(grade)), strict=True):
        page = f"{FOLDER}/{stem}{ending}"
        data = text.encode("utf-8", "replace")
        try:
            old = (folder / page).read_bytes()
        except FileNotFoundError:
            old = None
        if old == data:
            continue
        # Kept first, and in doubt: what cannot be kept is not written over.
        if old is not None and (before is None or (before and zlib.crc32(old) != before.get(f"{stem}{ending}"))):
            kept = Path(PUBLISHED, FOLDER, f"{stem}-{_digest(old)}{ending}")
            write_whole(folder / kept, [old], private=True, sync=True)
            yield f"{page} was changed by hand; what it was is kept as {kept.as_posix()}"
        write_whole(folder / page, [data], private=True)


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name each student's feedback below `FOLDER` as the platform does, without its ending; numbers part equal ones.

    What no system can write is written otherwise.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for item in found.submissions.items:
        # With room for an ending, a number, and the digest of one that is kept.
        plain = "/".join(file_name(part, room=32) for part in item.feedback_name("").split("/"))
        name, number = plain, 1
        while name.casefold() in taken:
            number += 1
            name = f"{plain}-{number}"
        taken.add(name.casefold())
        names[item.student] = name
    return names


def write_feedback(
    found: ClassGrades, folder: Path, figures: Path | None, progress: Callable[[int], None] | None = None
) -> tuple[list[str], list[str]]:
    """Write the feedback of a class into a folder and a zip; say who has none and why, and what was changed by hand.

    `figures`: Folder of each student's figures; None if none are drawn. A name that no system can write costs that
    student only.
    """
    names, before = feedback_names(found), _written_before(folder / ARCHIVE)
    lost: list[str] = []
    changed: list[str] = []
    written: list[str] = []
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        for grade, item in zip(found.grades, found.submissions.items, strict=True):
            drawn = found.figures.get(grade.student, {}) if figures is not None else {}
            paths = {name: (figure_path(figures or Path(), item, name), words) for name, words in drawn.items()}
            try:
                changed += _write_page(folder, before, grade, names[grade.student], paths)
                written.append(names[grade.student])
            except OSError as error:
                if error.errno in _FOR_ALL:
                    raise
                lost.append(f"no feedback for {grade.name}: {error.strerror or error}")
            if progress is not None:
                progress(len(lost) + len(written))
        _write_archive(folder, sorted(written))
    return sorted(lost), sorted(changed)


def _written_before(archive: Path) -> dict[str, int] | None:
    """Give the checksum of each page as it was written last, by name; None where they cannot be read, {} for none."""
    try:
        with zipfile.ZipFile(archive) as pages:
            return {page.filename: page.CRC for page in pages.infolist()}
    except FileNotFoundError:
        return {}
    except (OSError, zipfile.BadZipFile, NotImplementedError, struct.error, ValueError):
        return None


def _write_archive(folder: Path, names: list[str]) -> None:
    """Zip the feedback of this class, and of nobody else, to the same bytes."""
    with (
        new_file(folder / ARCHIVE, private=True) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive,
    ):
        for name in (f"{name}{ending}" for name in names for ending in ENDINGS):
            entry = zipfile.ZipInfo(name)  # of 1980: the bytes of a zip must not depend on the time
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, (folder / FOLDER / name).read_bytes())
