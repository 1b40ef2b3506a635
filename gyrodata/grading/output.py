"""The folder of the grades: what a run writes, what it keeps, and what waits for a person."""

from __future__ import annotations

import hashlib
import struct
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, combinations, count
from pathlib import Path, PurePosixPath

from gyrodata.diagnostics import GRADES_FOLDER_CANNOT_BE_WRITTEN, JOURNAL_LINES_LOST
from gyrodata.disk import file_name, new_file, telling, write_whole
from gyrodata.errors import Diagnostic
from gyrodata.grading import exports, ledger
from gyrodata.grading.classroom import JOURNAL, ClassGrades, figure_path
from gyrodata.grading.exports.gradebooks import Filled, Ours, fill_book, platform_of
from gyrodata.grading.exports.pages import class_page, feedback_comment, feedback_html, feedback_markdown
from gyrodata.grading.grade import Grade
from gyrodata.readings import listing
from gyrodata.reporting.values import count_text

FIGURES = "figures"
SHOWN = 20  # changes that are printed; with --dry-run all of them
TABLE, PUBLISHED = "grades.csv", "published"


def fill_gradebook(
    data: bytes,
    name: str,
    assignment: str | None,
    grades: Collection[Grade],
    ids: Mapping[str, Mapping[str, str]],
    ours: Ours | None = None,
) -> dict[str, Filled]:
    """Fill the gradebook of a platform as `fill_book` does; return it by the name of the file to write."""
    lms, comments = platform_of(data, name), {grade.student: feedback_comment(grade) for grade in grades}
    sheet = fill_book(lms, data, name, grades, assignment=assignment, comments=comments, ids=ids, ours=ours)
    # Blackboard's sheet with tabs ends in .xls.
    return {f"{lms}.{'xls' if name.lower().endswith('.xls') else 'csv'}": sheet}


# --- earlier tables in the folder: ``grades-DIGEST.csv`` for each that gyro wrote, and
# ``grades-by-hand-DIGEST.csv`` for each that a person changed -------------------------------------------------------


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]


def _read(path: Path) -> dict[str, dict[str, str]]:
    return exports.read_table(path.read_bytes().decode("utf-8-sig", "replace")) or {}


def _tables_from_here(folder: Path) -> list[dict[str, dict[str, str]]]:
    return [_read(path) for path in sorted((folder / PUBLISHED).glob("grades-????????????.csv"))]


def changes_in(folder: Path, found: ClassGrades) -> tuple[exports.Change, ...] | None:
    """Compare with the table of grades in the folder; None if the file there is not such a table."""
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        path = folder / TABLE
        before = path.read_bytes().decode("utf-8-sig", "replace") if path.is_file() else ""
        return exports.compare_tables(before, found.table) if before else ()


def totals_from_here(folder: Path, desk: ledger.Desk, students: Iterable[str]) -> Ours:
    """Return all totals that gyro wrote for each student; None for a student whose total the desk decides."""
    tables = _tables_from_here(folder)
    return {
        student: None
        if desk.decides(student, exports.TOTAL)
        else {number for table in tables if (number := table.get(student, {}).get(exports.TOTAL))}
        for student in students
    }


def _keep_table(folder: Path, table: bytes) -> None:
    """Keep the table that is to be written, and the table that is there if a person changed it."""
    kept, old = {f"grades-{_digest(table)}.csv": table}, folder / TABLE
    if old.is_file():
        before = old.read_bytes()
        if not (folder / PUBLISHED / f"grades-{_digest(before)}.csv").is_file():
            kept = {f"grades-by-hand-{_digest(before)}.csv": before} | kept
    for name, data in kept.items():
        path = folder / PUBLISHED / name
        if not path.is_file() or path.read_bytes() != data:
            write_whole(path, [data], private=True, sync=True)


def _changed_by_hand(found: ClassGrades, folder: Path) -> Iterator[ledger.Offer]:
    """Offer the cells that a person changed in a table, if no table of gyro, old or new, agrees with them."""
    tables = [*_tables_from_here(folder), exports.read_table(found.table) or {}]
    most = {exports.TOTAL: found.rubric.points} | {one.id: one.points for one in found.rubric.criteria}
    for path in sorted((folder / PUBLISHED).glob("*by-hand-*.csv")):
        for student, row in _read(path).items():
            rows = [table[student] for table in tables if student in table]
            for column, value in row.items():
                known = [one.get(column, "") for one in rows]
                where, reason = f"{column} was set by hand in {TABLE}", f"{TABLE} was changed by hand"
                if not value or student not in found.names or any(ledger.same_value(value, one) for one in known):
                    continue
                if column in most:
                    yield ledger.offer_points(student, column, value, most[column], where, reason)
                elif not any(column in one for one in rows):
                    yield ledger.Offer(student, "comment", value, where, reason)


# --- what waits for a person, and what is written -----------------------------------------------------------


def find_offers(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> list[ledger.Offer]:
    """List the lines that wait for a person, without those that the desk decides; lines of one reason together."""
    offer, waits, total = ledger.Offer, found.desk.waits, exports.TOTAL
    changed = list(_changed_by_hand(found, folder))
    for student, value in (pair for sheet in filled.values() for pair in sheet.by_hand):
        where, reason = "is in the gradebook", "other points are in the gradebook"
        changed.append(ledger.offer_points(student, total, value, found.rubric.points, where, reason))
    ungraded, looks, points = list[ledger.Offer](), list[ledger.Offer](), list[ledger.Offer]()
    for grade in found.grades:
        if grade.why is not None:
            what, reason = total, "a part cannot be judged" if grade.own else "the log cannot be used"
            if grade.own and grade.reported_inertia is None:
                what, reason = "reported", "no I_zz is reported"
            ungraded.append(offer(grade.student, what, "", grade.why, f"no grade: {reason}"))
        looks += [offer(grade.student, total, "", look, ledger.in_general(look)) for look in grade.look]
        for mark in grade.marks if grade.status in ("so far", "not graded") else ():
            if mark.waits:
                reason = f"points to give: {mark.title}"
                points.append(offer(grade.student, mark.criterion, "", mark.reason, reason))
    # A line without a value gives nobody a grade, and a flag is settled by its students.
    flags = _open_flags(found)
    offers = [*filter(waits, changed), *ungraded, *filter(waits, looks), *flags, *filter(waits, points)]
    reasons = list(dict.fromkeys(one.reason for one in offers))
    return sorted(dict.fromkeys(offers), key=lambda one: reasons.index(one.reason))


def _open_flags(found: ClassGrades) -> Iterator[ledger.Offer]:
    """Offer each flag that is not settled for all its students."""
    desk = found.desk
    graded = {one for one in found.names if any(desk.value(one, what) is not None for what in ledger.SETTLING)}
    single = frozenset[str]().union(*(group for group in desk.settled if len(group) == 1))
    known = [*desk.partners, *found.partners, *desk.settled]
    for flag in found.flags:
        # Each pair of a flag is settled; or each student, if it is about other logs too.
        if flag.previous or len(flag.students) == 1:
            settled = graded | single | (set(flag.students) if frozenset(flag.students) in desk.settled else set())
            waits = not settled.issuperset(flag.students)
        else:
            waits = not all(
                graded.issuperset(pair) or single.intersection(pair) or any(group.issuperset(pair) for group in known)
                for pair in combinations(flag.students, 2)
            )
        if waits:
            words = f"flag: {flag.kind}"
            yield ledger.Offer(flag.students[0], ledger.FLAG, "", f"{words}: {flag.evidence}", words, flag)


def write_results(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> str:
    """Write everything but the feedback, and keep a table that a person changed; say how many lines are open."""
    names = feedback_names(found)
    files = {
        item.student: ", ".join(PurePosixPath(name).name for name in item.beside_log)
        for item in found.submissions.items
    }
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        _keep_table(folder, found.table.encode("utf-8", "replace"))
        offers = find_offers(found, folder, filled)
        texts: dict[str, Iterable[str]] = {
            ledger.TODO: [ledger.todo_csv(offers, found.names, files)],
            TABLE: [found.table],
            "flags.csv": [exports.flags_csv(found.flags)],
            "class.html": [
                class_page(found, lambda student: f"{FEEDBACK}/{names[student]}.html", offers, files, folder)
            ],
            "grades.json": exports.grades_document(found),
        }
        for name, parts in texts.items():
            data = (part.encode("utf-8", "replace") for part in parts)
            write_whole(folder / name, data, private=True, sync=name == TABLE)
        for name, sheet in filled.items():
            write_whole(folder / name, [sheet.data], private=True)
    return f"; {count_text(len(offers), 'line')} for you in {folder / ledger.TODO}" if offers else ""


# --- the feedback of a class, in files named as the platform accepts them, and a zip of all ------------------


FEEDBACK, ARCHIVE, ENDINGS = "feedback", "feedback.zip", (".html", ".md")


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name the feedback of each student below `FEEDBACK`, without ending; equal names get a number.

    The names are those that the platform accepts, unless no system can write them.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for item in found.submissions.items:
        # With room for an ending, a number, and the digest of a page that is kept.
        plain = "/".join(file_name(part, room=32) for part in item.feedback_name.split("/"))
        forms = chain([plain], (f"{plain}-{number}" for number in count(2)))
        names[item.student] = next(one for one in forms if one.casefold() not in taken)
        taken.add(names[item.student].casefold())
    return names


def write_feedback(
    found: ClassGrades, folder: Path, figures: Path | None, progress: Callable[[int], None] | None = None
) -> list[str]:
    """Write the feedback of a class into a folder and a zip.

    `figures` is the folder with the figures of each student, None if none are drawn. Returns lines about pages that a
    person had changed.
    """
    names, changed = feedback_names(found), list[str]()
    before: dict[str, int] | None = {}
    with telling(folder, GRADES_FOLDER_CANNOT_BE_WRITTEN):
        try:
            with zipfile.ZipFile(folder / ARCHIVE) as pages:
                before = {page.filename: page.CRC for page in pages.infolist()}
        except FileNotFoundError:
            before = {}
        except (OSError, zipfile.BadZipFile, NotImplementedError, struct.error, ValueError):
            before = None  # any page may have been changed
        for number, (grade, item) in enumerate(zip(found.grades, found.submissions.items, strict=True), 1):
            name, drawn = names[grade.student], found.figures.get(grade.student, {}) if figures else {}
            pictures = {
                one: (figure_path(figures or Path(), item, one).read_bytes(), words) for one, words in drawn.items()
            }
            texts = feedback_html(grade, pictures), feedback_markdown(grade)
            for ending, text in zip(ENDINGS, texts, strict=True):
                changed += _write_page(folder, before, name, ending, text.encode("utf-8", "replace"))
            if progress is not None:
                progress(number)
        with (
            new_file(folder / ARCHIVE, private=True) as file,
            zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive,
        ):
            for name in (f"{name}{ending}" for name in sorted(names.values()) for ending in ENDINGS):
                entry = zipfile.ZipInfo(name)  # dated 1980: the bytes of the zip must not depend on the time
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, (folder / FEEDBACK / name).read_bytes())
    return sorted(changed)


def _write_page(folder: Path, before: Mapping[str, int] | None, name: str, ending: str, data: bytes) -> Iterator[str]:
    """Write one page, and keep the old one if a person changed it; `before` are the checksums of the last run."""
    page = f"{FEEDBACK}/{name}{ending}"
    old = (folder / page).read_bytes() if (folder / page).exists() else None
    if old == data:
        return
    # The old page is kept first: it must not be lost if it cannot be kept.
    if old is not None and (before is None or (before and zlib.crc32(old) != before.get(f"{name}{ending}"))):
        kept = Path(PUBLISHED, FEEDBACK, f"{name}-{_digest(old)}{ending}")
        write_whole(folder / kept, [old], private=True, sync=True)
        yield f"{page} was changed by hand; what it was is kept as {kept.as_posix()}"
    write_whole(folder / page, [data], private=True)


# --- what a run says -------------------------------------------------------------------------------------------


def summary(found: ClassGrades) -> Iterator[str]:
    """Say who was graded in this run, and why."""
    again = exports.grouped((why, found.names[student]) for student, why in found.again.items())
    yield from (f"graded {len(names)} ({why}): {listing(names, 5)}" for why, names in again.items())
    if known := len(found.grades) - len(found.again):
        yield f"kept {known} as graded before"
    if waiting := found.desk.waiting:
        yield f"{count_text(waiting, 'line')} {'waits' if waiting == 1 else 'wait'} in desk.csv for a value"
    if found.desk.left:
        yield f"desk.csv: {count_text(len(found.desk.left), 'line')} without a value, left as gyro has it"
    if found.damaged:
        message = f"{count_text(found.damaged, 'line')} of the journal cannot be read; what was there was graded again"
        yield str(Diagnostic.of(JOURNAL_LINES_LOST, message, file=JOURNAL))


def change_lines(changes: Sequence[exports.Change] | None, dry_run: bool) -> Iterator[str]:
    """Say what changes in the table of grades."""
    kept = "" if dry_run else "; what it was is kept in published"
    if changes is None:
        yield f"grades.csv is not a table of grades as gyro writes it{kept}"
    elif changes:
        yield f"grades.csv {'would change' if dry_run else 'changes'} for {len(changes)}{kept}:"
        shown = changes if dry_run else changes[:SHOWN]
        yield from (f"  {change}" for change in shown)
        if len(changes) > len(shown):
            yield f"  and {len(changes) - len(shown)} more"
    elif dry_run:
        yield "grades.csv would not change, or is not there yet"


def filled_lines(filled: Mapping[str, Filled], dry_run: bool) -> Iterator[str]:
    """List the new and old entries of a gradebook, and the students without an entry."""
    for name, sheet in filled.items():
        without = {who for who, _ in sheet.skipped}.difference(sheet.filled)
        yield f"{name} {'would be' if dry_run else 'is'} filled for {len(sheet.filled)}, not for {len(without)}"
        if sheet.changed:
            yield f"  {count_text(len(sheet.changed), 'cell')} had something else:"
        yield from (f"  {student}: {before} → {after}" for student, before, after in sheet.changed)
        skipped = exports.grouped((why, who) for who, why in sheet.skipped)
        yield from (f"  {why}: {listing(names, 10)}" for why, names in skipped.items())
