"""The folder of the grades: what a run writes and keeps, and open questions."""

from __future__ import annotations

import hashlib
import struct
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from itertools import count
from pathlib import Path
from posixpath import basename

from gyrodata.base.disk import file_name, new_file, write_whole
from gyrodata.base.errors import Diagnostic
from gyrodata.base.version import __version__
from gyrodata.grading import exports, ledger
from gyrodata.grading.classroom import (
    JOURNAL,
    OTHER_VERSION,
    ClassGrades,
)
from gyrodata.grading.exports.gradebooks import Filled, Ours
from gyrodata.grading.exports.pages import class_page, environment, feedback_pages
from gyrodata.grading.yardsticks import grouped
from gyrodata.readings import listing
from gyrodata.reporting.values import count_text
from gyrodata.results import encode

TABLE, PUBLISHED = "grades.csv", "published"
RUBRIC = "rubric-used.toml"


# --- earlier tables in the folder: ``grades-DIGEST.csv`` for each that gyro wrote, and
# ``grades-by-hand-DIGEST.csv`` for each that a person changed
# -------------------------------------------------------


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]


def totals_from_here(folder: Path, desk: ledger.Desk, students: Iterable[str]) -> Ours:
    """Return all totals that gyro wrote for each student.

    None for a student whose total the desk decides.
    """
    files = (folder / PUBLISHED).glob("grades-????????????.csv")
    tables = [exports.read_table(file.read_bytes()) or {} for file in files]
    totals: dict[str, set[str] | None] = {}
    for student in students:
        rows = [table[student] for table in tables if student in table]
        totals[student] = {row[exports.TOTAL] for row in rows}
        if desk.decides(student, exports.TOTAL):
            totals[student] = None
    return totals


def _keep_table(folder: Path, table: bytes) -> Iterator[str]:
    """Keep a copy of the table that is to be written.

    If a person changed the table that is there, this table is kept as well, and a
    message reports it.
    """
    path = folder / TABLE
    kept = folder / PUBLISHED
    before = path.read_bytes() if path.is_file() else table
    is_kept = (kept / f"grades-{_digest(before)}.csv").is_file()
    if before != table and not is_kept:
        name = f"grades-by-hand-{_digest(before)}.csv"
        write_whole(kept / name, [before], private=True, sync=True)
        place = f"it is kept as {PUBLISHED}/{name}"
        todo = f"write your points into {ledger.DESK}"
        yield f"{TABLE} was changed by hand: {place}; {todo}"
    copy = kept / f"grades-{_digest(table)}.csv"
    write_whole(copy, [table], private=True, sync=True)


def write_rubric(folder: Path, text: bytes) -> None:
    """Write the rubric, with the version that grades by it in the first line."""
    head = b"# gyrodata %b graded by this rubric.\n"
    lines = text.removeprefix(b"\xef\xbb\xbf").splitlines(keepends=True)
    start, end = head.split(b"%b")
    kept = [head % __version__.encode()]
    for line in lines:
        is_head = line.startswith(start) and line.endswith(end)
        if not is_head:
            kept.append(line)
    write_whole(folder / RUBRIC, kept, private=True)


# --- what is written ---


def write_results(
    class_grades: ClassGrades, folder: Path, filled: Filled | None, anonymous: bool
) -> Iterator[str]:
    """Write everything but the feedback, and keep a table that a person changed.

    Say where to look. `anonymous`: The page shows ids, and nothing else that may
    contain the name of a student.
    """
    names = feedback_names(class_grades)
    pages = {key: f"{FEEDBACK}/{name}.html" for key, name in names.items()}
    files = {}
    for submission in class_grades.submissions.items:
        own = [basename(file) for file in submission.files_to_read]
        files[submission.student] = listing(own, exports.MOST_NAMED)
    yield from _keep_table(folder, class_grades.table.encode("utf-8", "replace"))
    offers = ledger.find_offers(class_grades, filled.by_hand if filled else ())
    if anonymous:
        page = class_page(class_grades.without_names(), {}, offers, None)
    else:
        page = class_page(class_grades, pages, offers, folder)
    texts = {
        ledger.TODO: ledger.todo_csv(offers, class_grades.names, files),
        TABLE: class_grades.table,
        "class.html": page,
        "flags.csv": exports.flags_csv(class_grades.flags),
        "grades.json": "".join(exports.grades_document(class_grades)),
    }
    for name, text in texts.items():
        data = text.encode("utf-8", "replace")
        write_whole(folder / name, [data], private=True, sync=name == TABLE)
    if filled is not None:
        write_whole(folder / filled.file, [filled.data], private=True)
    waiting = ""
    if offers:
        lines = count_text(len(offers), "line")
        waiting = f"; {lines} for you in {folder / ledger.TODO}"
    yield f"grades: {folder / TABLE}{waiting}"
    yield f"class: {folder / 'class.html'}"


# --- the feedback of a class, in files named as the platform accepts them, and a zip of
# all ------------------


FEEDBACK, ARCHIVE, ENDINGS = "feedback", "feedback.zip", (".html", ".md")


def feedback_names(class_grades: ClassGrades) -> dict[str, str]:
    """Name the feedback of each student, without ending; equal names get a number.

    The names are those that the platform accepts, unless no system can write them; a
    student who handed in nothing has none.
    """
    names = dict[str, str]()
    taken = set[str]()
    for item in class_grades.submissions.items:
        if not item.feedback_stem:
            continue
        # With room for an ending, a number, and the digest of a page that is kept.
        parts = item.feedback_name.split("/")
        plain = "/".join(file_name(part, room=32) for part in parts)
        name = plain
        numbers = count(2)
        while name.casefold() in taken:
            name = f"{plain}-{next(numbers)}"
        names[item.student] = name
        taken.add(name.casefold())
    return names


def write_feedback(class_grades: ClassGrades, folder: Path) -> list[str]:
    """Write the feedback of a class into a folder and a zip.

    A page that a person has changed, and one of a student who is no longer in the
    class, is kept in `PUBLISHED`: a line is returned about each.
    """
    names = feedback_names(class_grades)
    archived = _read_archive(folder / ARCHIVE)
    # The digest of each page's content, which is also its comment in the zip.
    digests: dict[str, bytes] = {}
    kept: list[str] = []
    for grade in class_grades.grades:
        if grade.student not in names:
            continue
        content = repr((__version__, encode(grade))).encode()
        pages = [f"{names[grade.student]}{ending}" for ending in ENDINGS]
        digest = _digest(content).encode()
        digests |= dict.fromkeys(pages, digest)
        there = [(_checksum(folder / FEEDBACK / page), digest) for page in pages]
        if there != [archived.get(page) for page in pages]:
            texts = zip(pages, feedback_pages(grade).values(), strict=True)
            kept += _write_pages(folder, dict(texts), archived)
    for page in archived.keys() - digests.keys():
        kept += _keep(folder, page, "belongs to no submission that is here now: it")
        (folder / FEEDBACK / page).unlink(missing_ok=True)
    if digests != {page: comment for page, (_, comment) in archived.items()}:
        _write_archive(folder, digests)
    return sorted(kept)


def _write_pages(
    folder: Path, texts: Mapping[str, str], archived: Mapping[str, tuple[int, bytes]]
) -> list[str]:
    """Write the pages of a student; keep each one that a person has changed."""
    kept: list[str] = []
    for page, text in texts.items():
        path = folder / FEEDBACK / page
        data = text.encode("utf-8", "replace")
        as_written, _ = archived.get(page, (None, b""))
        if _checksum(path) != as_written:
            kept += _keep(folder, page, "was changed by hand; what it was", data)
        write_whole(path, [data], private=True)
    return kept


def _read_archive(path: Path) -> dict[str, tuple[int, bytes]]:
    """Return the checksum and the comment of each page in the zip, if it is whole."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {
                page.filename: (page.CRC, page.comment) for page in archive.infolist()
            }
    except (
        OSError,
        zipfile.BadZipFile,
        NotImplementedError,
        struct.error,
        ValueError,
    ):
        return {}


def _checksum(page: Path) -> int | None:
    """Return the checksum of a page as a zip contains it; None without the page."""
    if not page.exists():
        return None
    return zlib.crc32(page.read_bytes())


def _write_archive(folder: Path, digests: Mapping[str, bytes]) -> None:
    """Write all pages into a zip; the same pages give the same bytes."""
    with (
        new_file(folder / ARCHIVE, private=True) as file,
        zipfile.ZipFile(file, "w") as archive,
    ):
        for page in sorted(digests):
            entry = zipfile.ZipInfo(page)  # dated 1980
            entry.external_attr = 0o644 << 16
            entry.comment = digests[page]
            data = (folder / FEEDBACK / page).read_bytes()
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, compresslevel=1)


def _keep(folder: Path, page: str, why: str, new: bytes = b"") -> list[str]:
    """Keep a page that gets other contents, or is removed, below `PUBLISHED`.

    Return a line about it.
    """
    path = folder / FEEDBACK / page
    old = path.read_bytes() if path.exists() else new
    if old == new:
        return []
    kept = Path(PUBLISHED, FEEDBACK, page)
    kept = kept.with_stem(f"{kept.stem}-{_digest(old)}")
    write_whole(folder / kept, [old], private=True, sync=True)
    return [f"{FEEDBACK}/{page} {why} is kept as {kept.as_posix()}"]


# --- what a run says ---


def _reasons(
    class_grades: ClassGrades, changes: Iterable[exports.Change]
) -> dict[str, list[str]]:
    """Say why points change for students whom another version had graded.

    These are the reasons of the criteria with other points, by student.
    """
    grades = {grade.student: grade for grade in class_grades.grades}
    reasons = {}
    for change in changes:
        if not class_grades.again.get(change.student, "").startswith(OTHER_VERSION):
            continue
        columns = [part.column for part in change.parts]
        marks = grades[change.student].marks
        changed = [mark for mark in marks if mark.criterion in columns]
        words = [f"{mark.criterion}: {mark.reason}" for mark in changed]
        reasons[change.student] = words
    return reasons


def describe_run(
    class_grades: ClassGrades,
    changes: Iterable[exports.Change] | None,
    filled: Filled | None,
    dry_run: bool,
) -> str:
    """Describe who was graded in this run, and why.

    The text also shows what changes in the table of grades, and who is in the
    gradebook.
    """
    lost = Diagnostic.named(
        "journal_lines_lost", JOURNAL, lines=count_text(class_grades.damaged, "line")
    )
    again = grouped(
        (why, class_grades.names[student])
        for student, why in class_grades.again.items()
    )
    left_out = filled.skipped if filled else []
    skipped = grouped((why, who) for who, why in left_out)
    values = {
        "class_grades": class_grades,
        "again": again,
        "lost": lost,
        "changes": changes,
        "reasons": _reasons(class_grades, changes or ()),
        "filled": filled,
        "skipped": skipped,
    }
    return environment().get_template("run.txt.jinja").render(values, dry_run=dry_run)
