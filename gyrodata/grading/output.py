"""The folder of the grades: what a run writes and keeps, and open questions."""

from __future__ import annotations

import hashlib
import struct
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain, count
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
    figure_path,
)
from gyrodata.grading.exports.gradebooks import Filled, Ours
from gyrodata.grading.exports.pages import class_page, environment, feedback_pages
from gyrodata.grading.yardsticks import grouped
from gyrodata.readings import listing
from gyrodata.reporting.values import count_text
from gyrodata.results import encode

FIGURES, TABLE, PUBLISHED = "figures", "grades.csv", "published"
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
    tables = [exports.read_table(one.read_bytes()) or {} for one in files]
    known = {
        student: {table[student][exports.TOTAL] for table in tables if student in table}
        for student in students
    }
    return {
        student: None if desk.decides(student, exports.TOTAL) else some
        for student, some in known.items()
    }


def _keep_table(folder: Path, table: bytes) -> Iterator[str]:
    """Keep a copy of the table that is to be written.

    If a person changed the table that is there, this table is kept as well, and a
    message reports it.
    """
    path = folder / TABLE
    kept = folder / PUBLISHED
    before = path.read_bytes() if path.is_file() else table
    if before != table and not (kept / f"grades-{_digest(before)}.csv").is_file():
        name = f"grades-by-hand-{_digest(before)}.csv"
        write_whole(kept / name, [before], private=True, sync=True)
        yield (
            f"{TABLE} was changed by hand: it is kept as {PUBLISHED}/{name}; write "
            f"your points into {ledger.DESK}"
        )
    write_whole(kept / f"grades-{_digest(table)}.csv", [table], private=True, sync=True)


def write_rubric(folder: Path, text: bytes) -> None:
    """Write the rubric, with the version that grades by it in the first line."""
    head = b"# gyrodata %b graded by this rubric.\n"
    lines = text.removeprefix(b"\xef\xbb\xbf").splitlines(keepends=True)
    start, end = head.split(b"%b")
    kept = [
        line for line in lines if not (line.startswith(start) and line.endswith(end))
    ]
    write_whole(folder / RUBRIC, [head % __version__.encode(), *kept], private=True)


# --- what is written ---


def write_results(
    found: ClassGrades, folder: Path, filled: Filled | None
) -> Iterator[str]:
    """Write everything but the feedback, and keep a table that a person changed.

    Say where to look.
    """
    names = feedback_names(found)
    files = {
        one.student: listing(
            [basename(file) for file in one.beside_log], exports.MOST_NAMED
        )
        for one in found.submissions.items
    }
    yield from _keep_table(folder, found.table.encode("utf-8", "replace"))
    offers = ledger.find_offers(found, filled.by_hand if filled else ())
    page = class_page(
        found, lambda student: f"{FEEDBACK}/{names[student]}.html", offers, folder
    )
    texts = {
        ledger.TODO: ledger.todo_csv(offers, found.names, files),
        TABLE: found.table,
        "class.html": page,
    }
    texts |= {
        "flags.csv": exports.flags_csv(found.flags),
        "grades.json": "".join(exports.grades_document(found)),
    }
    for name, text in texts.items():
        write_whole(
            folder / name,
            [text.encode("utf-8", "replace")],
            private=True,
            sync=name == TABLE,
        )
    if filled is not None:
        write_whole(folder / filled.file, [filled.data], private=True)
    waiting = (
        f"; {count_text(len(offers), 'line')} for you in {folder / ledger.TODO}"
        if offers
        else ""
    )
    yield f"grades: {folder / TABLE}{waiting}"
    yield f"class: {folder / 'class.html'}"


# --- the feedback of a class, in files named as the platform accepts them, and a zip of
# all ------------------


FEEDBACK, ARCHIVE, ENDINGS = "feedback", "feedback.zip", (".html", ".md")


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name the feedback of each student, without ending; equal names get a number.

    The names are those that the platform accepts, unless no system can write them.
    """
    names = dict[str, str]()
    taken = set[str]()
    for item in found.submissions.items:
        # With room for an ending, a number, and the digest of a page that is kept.
        plain = "/".join(
            file_name(part, room=32) for part in item.feedback_name.split("/")
        )
        forms = chain([plain], (f"{plain}-{number}" for number in count(2)))
        names[item.student] = next(one for one in forms if one.casefold() not in taken)
        taken.add(names[item.student].casefold())
    return names


def write_feedback(found: ClassGrades, folder: Path, figures: Path | None) -> list[str]:
    """Write the feedback of a class into a folder and a zip.

    `figures` is the folder with the figures of each student, None if none are drawn.
    Returns lines about pages that a person had changed, and of students who are no
    longer in the class.
    """
    names = feedback_names(found)
    archived = _read_archive(folder / ARCHIVE)
    changed: list[str] = []
    # The content of each page; the digest is also its comment in the zip.
    digests: dict[str, bytes] = {}
    for grade, item in zip(found.grades, found.submissions.items, strict=True):
        pictures = {}
        if figures is not None:
            for name, words in found.figures.get(grade.student, {}).items():
                picture = figure_path(figures, item, name).read_bytes()
                pictures[name] = (picture, words)
        checksums = [(zlib.crc32(data), words) for data, words in pictures.values()]
        content = repr((__version__, encode(grade), checksums)).encode()
        pages = [f"{names[grade.student]}{ending}" for ending in ENDINGS]
        digests |= dict.fromkeys(pages, _digest(content).encode())
        if not _are_up_to_date(folder, pages, digests, archived):
            texts = feedback_pages(grade, pictures).values()
            for page, text in zip(pages, texts, strict=True):
                data = text.encode("utf-8", "replace")
                changed += _replace_page(folder, page, data, archived)
    changed += _remove_other_pages(folder, digests, archived)
    comments = {name: comment for name, (_, comment) in (archived or {}).items()}
    if not archived or digests != comments:
        _write_archive(folder, digests)
    return sorted(changed)


_Archived = dict[str, tuple[int, bytes]] | None
"""Checksum and comment of each page in the zip; None without a zip, so that no page
counts as changed; empty if it cannot be read, so that any page may have been changed."""


def _read_archive(path: Path) -> _Archived:
    if not path.exists():
        return None
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


def _are_up_to_date(
    folder: Path,
    pages: Sequence[str],
    digests: Mapping[str, bytes],
    archived: _Archived,
) -> bool:
    """Return whether pages show the grade already, and nobody has changed them."""
    if not archived:
        return False
    for page in pages:
        path = folder / FEEDBACK / page
        if not path.exists():
            return False
        checksum = zlib.crc32(path.read_bytes())
        if archived.get(page) != (checksum, digests[page]):
            return False
    return True


def _replace_page(
    folder: Path, page: str, data: bytes, archived: _Archived
) -> list[str]:
    """Write a page; return a line about the old one if a person had changed it."""
    path = folder / FEEDBACK / page
    old = path.read_bytes() if path.exists() else None
    if old == data:
        return []
    changed = []
    is_ours = archived is None or zlib.crc32(old or b"") in archived.get(page, ())
    # The old page is kept first: it must not be lost if it cannot be kept.
    if old and not is_ours:
        kept = _keep(folder, page, old)
        changed.append(
            f"{FEEDBACK}/{page} was changed by hand; what it was is kept as {kept}"
        )
    write_whole(path, [data], private=True)
    return changed


def _remove_other_pages(
    folder: Path, digests: Mapping[str, bytes], archived: _Archived
) -> list[str]:
    """Keep the pages of students who are no longer in the class at another place."""
    changed = []
    for path in sorted((folder / FEEDBACK).rglob("*.*")):
        page = path.relative_to(folder / FEEDBACK).as_posix()
        if archived and page in archived and page not in digests:
            kept = _keep(folder, page, path.read_bytes())
            path.unlink()
            changed.append(
                f"{FEEDBACK}/{page} is of nobody in this class: it is kept as {kept}"
            )
    return changed


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


def _keep(folder: Path, page: str, data: bytes) -> str:
    """Keep a page that gyro replaces or removes.

    Return its new place below the folder of the grades.
    """
    kept = Path(PUBLISHED, FEEDBACK, page).with_stem(
        f"{Path(page).stem}-{_digest(data)}"
    )
    write_whole(folder / kept, [data], private=True, sync=True)
    return kept.as_posix()


# --- what a run says ---


def _reasons(
    found: ClassGrades, changes: Iterable[exports.Change]
) -> dict[str, list[str]]:
    """Say why points change for students whom another version had graded.

    These are the reasons of the criteria with other points, by student.
    """
    grades = {grade.student: grade for grade in found.grades}
    reasons = {}
    for change in changes:
        if not found.again.get(change.student, "").startswith(OTHER_VERSION):
            continue
        columns = [part.column for part in change.parts]
        reasons[change.student] = [
            f"{mark.criterion}: {mark.reason}"
            for mark in grades[change.student].marks
            if mark.criterion in columns
        ]
    return reasons


def told_of(
    found: ClassGrades,
    changes: Iterable[exports.Change] | None,
    filled: Filled | None,
    dry_run: bool,
) -> str:
    """Describe who was graded in this run, and why.

    The text also shows what changes in the table of grades, and who is in the
    gradebook.
    """
    lost = Diagnostic.named(
        "journal_lines_lost", JOURNAL, lines=count_text(found.damaged, "line")
    )
    again = grouped((why, found.names[student]) for student, why in found.again.items())
    skipped = grouped((why, who) for who, why in filled.skipped) if filled else {}
    values = {
        "found": found,
        "again": again,
        "lost": lost,
        "changes": changes,
        "reasons": _reasons(found, changes or ()),
        "filled": filled,
        "skipped": skipped,
    }
    return environment().get_template("run.txt.jinja").render(values, dry_run=dry_run)
