"""The folder of the grades: what a run writes, what it keeps, and what waits for a person."""

from __future__ import annotations

import hashlib
import struct
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from itertools import chain, count
from pathlib import Path
from posixpath import basename

from gyrodata.base.disk import file_name, new_file, write_whole
from gyrodata.base.errors import Diagnostic
from gyrodata.base.version import __version__
from gyrodata.grading import exports, ledger
from gyrodata.grading.classroom import JOURNAL, ClassGrades, figure_path
from gyrodata.grading.exports.gradebooks import Filled, Ours
from gyrodata.grading.exports.pages import class_page, environment, feedback_pages
from gyrodata.grading.yardsticks import grouped
from gyrodata.reporting.values import count_text
from gyrodata.results import encode

FIGURES, TABLE, PUBLISHED = "figures", "grades.csv", "published"


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
    path, kept = folder / TABLE, folder / PUBLISHED
    before = path.read_bytes() if path.is_file() else table
    if before != table and not (kept / f"grades-{_digest(before)}.csv").is_file():
        name = f"grades-by-hand-{_digest(before)}.csv"
        write_whole(kept / name, [before], private=True, sync=True)
        yield (
            f"{TABLE} was changed by hand: it is kept as {PUBLISHED}/{name}; write "
            f"your points into {ledger.DESK}"
        )
    write_whole(kept / f"grades-{_digest(table)}.csv", [table], private=True, sync=True)


MOST_LISTED = (
    50  # files in one cell: a spreadsheet program reads at most 32,767 letters
)


def _listed(files: list[str]) -> str:
    more = f" and {len(files) - MOST_LISTED} more" if len(files) > MOST_LISTED else ""
    return ", ".join(files[:MOST_LISTED]) + more


# --- what is written ---


def write_results(
    found: ClassGrades, folder: Path, filled: Filled | None
) -> Iterator[str]:
    """Write everything but the feedback, and keep a table that a person changed.

    Say where to look.
    """
    names = feedback_names(found)
    files = {
        one.student: _listed([basename(file) for file in one.beside_log])
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
    """Name the feedback of each student below `FEEDBACK`, without ending; equal names get a number.

    The names are those that the platform accepts, unless no system can write them.
    """
    names, taken = dict[str, str](), set[str]()
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
    names, changed = feedback_names(found), list[str]()
    before: dict[str, tuple[int, bytes]] | None = (
        None  # without a zip, no page counts as changed
    )
    if (folder / ARCHIVE).exists():
        try:
            with zipfile.ZipFile(folder / ARCHIVE) as archive:
                before = {
                    page.filename: (page.CRC, page.comment)
                    for page in archive.infolist()
                }
        except (
            OSError,
            zipfile.BadZipFile,
            NotImplementedError,
            struct.error,
            ValueError,
        ):
            before = {}  # any page may have been changed
    contents = dict[
        str, bytes
    ]()  # a digest of what each page shows, which is also its comment in the zip
    for grade, item in zip(found.grades, found.submissions.items, strict=True):
        pages, pictures = [f"{names[grade.student]}{ending}" for ending in ENDINGS], {}
        if figures is not None:
            drawn = found.figures.get(grade.student, {})
            pictures = {
                one: (figure_path(figures, item, one).read_bytes(), words)
                for one, words in drawn.items()
            }
        about = (
            __version__,
            encode(grade),
            [(zlib.crc32(data), words) for data, words in pictures.values()],
        )
        content = _digest(repr(about).encode()).encode()
        contents |= dict.fromkeys(pages, content)
        old = {
            page: path.read_bytes()
            for page in pages
            if (path := folder / FEEDBACK / page).exists()
        }
        # Pages that show this already, and that nobody has changed, are not written
        # again.
        if [(zlib.crc32(data), content) for data in old.values()] != [
            before and before.get(page) for page in pages
        ]:
            for page, text in zip(
                pages, feedback_pages(grade, pictures).values(), strict=True
            ):
                data, was = text.encode("utf-8", "replace"), old.get(page)
                known = (
                    was is None
                    or before is None
                    or zlib.crc32(was) in before.get(page, ())
                )
                # The old page is kept first: it must not be lost if it cannot be kept.
                if was and was != data and not known:
                    kept = _keep(folder, page, was)
                    changed.append(
                        f"{FEEDBACK}/{page} was changed by hand; what it was is kept as {kept}"
                    )
                if was != data:
                    write_whole(folder / FEEDBACK / page, [data], private=True)
    for path in sorted((folder / FEEDBACK).rglob("*.*")):
        page = path.relative_to(folder / FEEDBACK).as_posix()
        if before and page in before and page not in contents:
            kept = _keep(folder, page, path.read_bytes())
            path.unlink()
            changed.append(
                f"{FEEDBACK}/{page} is of nobody in this class: it is kept as {kept}"
            )
    if not before or contents != {
        name: comment for name, (_, comment) in before.items()
    }:
        with (
            new_file(folder / ARCHIVE, private=True) as file,
            zipfile.ZipFile(file, "w") as archive,
        ):
            for name in sorted(contents):
                entry = zipfile.ZipInfo(
                    name
                )  # dated 1980, so that the same pages give the same bytes
                entry.external_attr, entry.comment = 0o644 << 16, contents[name]
                archive.writestr(
                    entry,
                    (folder / FEEDBACK / name).read_bytes(),
                    zipfile.ZIP_DEFLATED,
                    compresslevel=1,
                )
    return sorted(changed)


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
        "filled": filled,
        "skipped": skipped,
    }
    return environment().get_template("run.txt.jinja").render(values, dry_run=dry_run)
