"""What a student gets back: the points, what was found in their numbers, how to check a slip; and all that as files."""

from __future__ import annotations

import base64
import re
import unicodedata
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrodata.grading.accepted_fits import fit_words
from gyrodata.grading.classroom import ClassGrades
from gyrodata.grading.criteria import factor_text
from gyrodata.grading.grade import Grade
from gyrodata.grading.journal import cannot_write, write_changed
from gyrodata.grading.run import GradingOptions, figure_path
from gyrodata.grading.submissions import Submission
from gyrodata.reporting import inertia_text
from gyrodata.workers import Failed, in_workers

if TYPE_CHECKING:
    from jinja2 import Environment


CAPTIONS = {
    "period": "Precession period against spin, with the law that your runs give",
    "product": "Precession rate times spin for each torque: a level line if it is constant",
    "torque": "Torque against φ̇ψ̇; the slope is I_zz",
    "residuals": "What is left of each time when the fit is taken away",
}
"""What stands below each figure."""


def feedback_markdown(grade: Grade) -> str:
    """Write the feedback for one student as Markdown.

    Gives: Every name, note and number from outside is escaped; no clock time.
    """
    text = environment().get_template("feedback.md.jinja").render(_content(grade))
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def feedback_html(
    grade: Grade, figures: Mapping[str, bytes] | None = None, alt: Mapping[str, str] | None = None
) -> str:
    """Write the feedback for one student as one HTML page that needs nothing else.

    `figures`: PNG or SVG files by name: "period", "product", "torque", "residuals". Gives: Every name, note and number
    from outside is escaped; no clock time.
    """
    images = [
        {"uri": _data_uri(data), "alt": (alt or {}).get(name, ""), "caption": CAPTIONS.get(name, name)}
        for name, data in (figures or {}).items()
    ]
    return environment().get_template("feedback.html.jinja").render(_content(grade), images=images)


def feedback_comment(grade: Grade) -> str:
    """Write the feedback for one student in a few lines of plain text, for the comment field of a gradebook."""
    if grade.status != "graded":
        return f"Not graded yet; nothing is lost, and somebody will look at it. {_sentence(grade.why)}"
    lines = [f"{points_text(grade.points)} of {points_text(grade.out_of)} points."]
    lines += [f"A slip to look for: {_sentence(slip.words)} To check: {_sentence(slip.check)}" for slip in grade.slips]
    lines += [
        f"{_plain(one.title)}: {points_text(one.points)} of {points_text(one.out_of)}. {_sentence(one.reason)}"
        for one in grade.marks
        if one.points is not None and one.points < one.out_of
    ]
    if grade.late_reason:
        taken = f" {points_text(grade.late_deduction)} points were taken off for it." if grade.late_deduction else ""
        lines.append(f"{_sentence(grade.late_reason)}{taken}")
    return "\n".join(lines)


@lru_cache(maxsize=1)
def environment() -> Environment:
    """Give what reads the room's templates: HTML escaped, one-line filters for texts from outside."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    room = Environment(
        loader=PackageLoader("gyrodata.grading", "."),
        autoescape=lambda name: name is not None and name.endswith(".html.jinja"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    room.filters["md"] = _markdown_safe
    room.filters["plain"] = _plain
    room.filters["sentence"] = _sentence
    room.filters["fit_words"] = fit_words
    return room


def _content(grade: Grade) -> dict[str, Any]:
    """What the templates need besides the grade: the functions that write its numbers."""
    own = [
        {
            "words": fit_words(name),
            "text": inertia_text(fit["value"] or 0.0, fit["u"]),
            "matched": name == grade.matched,
        }
        for name, fit in grade.own.items()
    ]
    told = [one for one in grade.diagnostics if one["severity"] != "note"]
    return {
        "grade": grade,
        "own": own,
        "rows": _rows(grade),
        "told": told,
        "points": points_text,
        "factor": factor_text,
        "ratio": "" if grade.ratio is None else factor_text(grade.ratio),
        "slip_cost": _slip_cost(grade),
        "lead": _lead(grade),
    }


def _rows(grade: Grade) -> list[dict[str, Any]]:
    """One row for each criterion, a reason that is the same as above told once."""
    rows = []
    before = ""
    for one in grade.marks:
        rule = one.rule if one.points is not None and one.points < one.out_of else ""
        again = bool(one.reason) and one.reason == before
        rows.append({"mark": one, "reason": "as above" if again else one.reason, "rule": rule})
        before = one.reason
    return rows


def points_text(points: float | None) -> str:
    """Write points: "6", "4.35", or "–" where there are none yet."""
    return "–" if points is None else f"{points:.2f}".rstrip("0").rstrip(".")


def _slip_cost(grade: Grade) -> float | None:
    """Points that a named slip cost; None where it was not carried forward."""
    if not grade.slips:
        return None
    return next((m.detail["slip_cost"] for m in grade.marks if isinstance(m.detail.get("slip_cost"), float)), None)  # type: ignore[return-value]


def _lead(grade: Grade) -> str:
    """One warm line that is true of these marks."""
    short = [one for one in grade.marks if one.points is not None and one.points < one.out_of]
    if not short:
        return "All of it holds: your log, your value and its uncertainty. Well done."
    if grade.slips:
        return "One slip on the way from your runs to the answer is worth finding: see below."
    if len(short) == 1:
        return f"All is well but for one thing: {short[0].title[0].lower()}{short[0].title[1:]}."
    return "Below is what was found in your own numbers, and where the points went."


def _data_uri(data: bytes) -> str:
    kind = "image/png" if data.startswith(b"\x89PNG") else "image/svg+xml"
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


# Letters may need a joiner; nothing needs an override of the direction or a bell.
_KEPT_FORMATS = "\u200c\u200d"
_MARKDOWN_SIGNS = re.compile(r"([\\`*_\[\]|~$])")


def _plain(text: object) -> str:
    """One line without control characters."""
    line = " ".join(str(text).split())
    if line.isascii() and line.isprintable():
        return line
    return "".join(c for c in line if c in _KEPT_FORMATS or not unicodedata.category(c).startswith("C"))


def _sentence(text: object) -> str:
    """One line with a capital and a full stop."""
    line = _plain(text).rstrip(".")
    # "g is missing" and "φ̇ψ̇ scatters" begin with a symbol.
    first = line[:1].upper() if re.match("[a-z]{2}", line) else line[:1]
    return f"{first}{line[1:]}{'' if line.endswith(('?', '!')) else '.'}" if line else ""


def _markdown_safe(text: object) -> str:
    """One line that Markdown takes literally."""
    line = _MARKDOWN_SIGNS.sub(r"\\\1", _plain(text))
    return line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("://", ":\\//")


# --- the feedback of a class, in files named so that the platform takes them, and a zip of all --------------


FOLDER = "feedback"
ARCHIVE = "feedback.zip"
ENDINGS = (".html", ".md")


@dataclass(frozen=True, slots=True)
class _Task:
    """One student's feedback to be written."""

    grade: Grade
    submission: Submission
    figures: Mapping[str, str]
    """What each figure shows, by name; empty where the feedback has none."""


@dataclass(frozen=True)
class _Work:
    """How it is written, in a worker."""

    figures: Path | None

    def __call__(self, task: _Task) -> tuple[str, str]:
        """Give the page and the Markdown."""
        drawn = {}
        if self.figures is not None:
            drawn = {name: figure_path(self.figures, task.submission, name).read_bytes() for name in task.figures}
        return feedback_html(task.grade, drawn, task.figures), feedback_markdown(task.grade)


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name each student's feedback below `FOLDER`, without its ending, as the platform names it.

    Gives: By student. Two that would be called the same, which only a pattern of one's own can bring about, get
    numbers.
    """
    names: dict[str, str] = {}
    taken: set[str] = set()
    for item in found.submissions.items:
        plain = item.feedback_name("")
        name, number = plain, 1
        while name.casefold() in taken:
            number += 1
            name = f"{plain}-{number}"
        taken.add(name.casefold())
        names[item.student] = name
    return names


def write_feedback(
    found: ClassGrades, folder: Path, options: GradingOptions, progress: Callable[[int], None] | None = None
) -> tuple[str, ...]:
    """Write the feedback of a class into a folder and a zip.

    `folder`: Of the grades; the files go below ``feedback/`` in it. Gives: Why the feedback of some could not be
    written.
    """
    names = feedback_names(found)
    figures = found.figures if options.figures is not None else {}
    tasks = (
        _Task(grade, item, figures.get(grade.student, {}))
        for grade, item in zip(found.grades, found.submissions.items, strict=True)
    )
    lost: list[str] = []
    written: list[str] = []
    work, preload = _Work(options.figures), ["gyrodata.grading.grade"]
    for task, answer in in_workers(work, tasks, options.workers, options.limit, preload):
        if isinstance(answer, Failed):
            lost.append(f"no feedback for {task.grade.name}: {answer.why}")
        else:
            name = names[task.grade.student]
            for ending, text in zip(ENDINGS, answer, strict=True):
                write_changed(folder / FOLDER / f"{name}{ending}", text.encode("utf-8", "replace"))
            written.append(name)
        if progress is not None:
            progress(len(written) + len(lost))
    _write_archive(folder, sorted(written))
    return tuple(sorted(lost))


def _write_archive(folder: Path, names: list[str]) -> None:
    """Zip the feedback of this class, and of nobody else; the same files give the same bytes."""
    target = folder / ARCHIVE
    unfinished = target.with_name(f".{ARCHIVE}.part")
    try:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for name in (f"{name}{ending}" for name in names for ending in ENDINGS):
                entry = zipfile.ZipInfo(name)  # of 1980: a zip's bytes should not tell the time
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, (folder / FOLDER / name).read_bytes())
        unfinished.replace(target)
    except OSError as error:
        raise cannot_write(folder, error) from None
