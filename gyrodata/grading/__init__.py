"""A class: submissions in; grades, feedback and flags out.

Read `grade` for one student and `classroom` for a class. The names below are the room's front; each is loaded when it
is first used, for the command line asks for few of them at a time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gyrodata.grading.classroom import LIMIT, ClassGrades, CriterionFigures, GradingOptions, grade_class
    from gyrodata.grading.criteria import Mark
    from gyrodata.grading.desk import (
        FIGURES,
        PUBLISHED,
        TABLE,
        Gradebooks,
        changes_in,
        find_desk,
        totals_from_here,
        waiting_lines,
        write_feedback,
        write_results,
    )
    from gyrodata.grading.exports import Change, class_summary, grades_csv
    from gyrodata.grading.exports.class_json import GradesDocument, grade_lines, grades_document
    from gyrodata.grading.exports.class_page import class_page
    from gyrodata.grading.exports.gradebooks import Filled, fill_book, read_sheet
    from gyrodata.grading.exports.gradescope import autograder_files, grade_autograder, results_json
    from gyrodata.grading.feedback import feedback_html, feedback_markdown
    from gyrodata.grading.forensics import Fingerprint, Flag, fingerprint, flag_class
    from gyrodata.grading.grade import Decision, Grade, grade_submission, points_text, settle
    from gyrodata.grading.hand_in import read_hand_in
    from gyrodata.grading.journal import Basis, Entry, Journal, why_again
    from gyrodata.grading.lastrun import JOURNAL, digest_of, find_unchanged, keep_run
    from gyrodata.grading.late import judge_lateness
    from gyrodata.grading.ledger import DESK, TODO, Desk, read_desk
    from gyrodata.grading.platforms import PLATFORMS
    from gyrodata.grading.roster import Person, Roster, read_roster
    from gyrodata.grading.rubric import ACCEPTED, Rubric, default_rubric, default_rubric_text, read_rubric, rubric_shape
    from gyrodata.grading.slips import Slip, find_slips
    from gyrodata.grading.submissions import Submission, Submissions, find_submissions
    from gyrodata.grading.submissions.student_files import Answers, read_answers
    from gyrodata.grading.yardsticks import BenchScatter, Reference, class_references, class_scatter, distance, own_runs

__all__ = [
    "ACCEPTED", "DESK", "FIGURES", "JOURNAL", "LIMIT", "PLATFORMS", "PUBLISHED", "TABLE", "TODO",
    "Answers", "Basis", "BenchScatter", "Change", "ClassGrades", "CriterionFigures", "Decision", "Desk", "Entry",
    "Filled", "Fingerprint", "Flag", "Grade", "Gradebooks", "GradesDocument", "GradingOptions", "Journal", "Mark",
    "Person", "Reference", "Roster", "Rubric", "Slip", "Submission", "Submissions", "autograder_files",
    "changes_in", "class_page", "class_references", "class_scatter", "class_summary", "default_rubric",
    "default_rubric_text", "digest_of", "distance", "feedback_html", "feedback_markdown", "fill_book",
    "find_desk", "find_slips", "find_submissions", "find_unchanged", "fingerprint", "flag_class", "grade_autograder",
    "grade_class", "grade_lines", "grade_submission", "grades_csv", "grades_document", "judge_lateness", "keep_run",
    "own_runs", "points_text", "read_answers", "read_desk", "read_hand_in",
    "read_roster", "read_rubric", "read_sheet", "results_json", "rubric_shape", "settle", "totals_from_here",
    "waiting_lines", "why_again", "write_feedback", "write_results",
]  # fmt: skip

_MODULES = [
    "lastrun", "late", "rubric", "platforms", "submissions", "yardsticks", "slips", "criteria", "forensics", "grade",
    "hand_in", "journal", "ledger", "roster", "exports", "exports.gradebooks", "exports.class_page", "classroom",
    "exports.class_json", "desk", "feedback", "exports.gradescope",
]  # fmt: skip
"""Each after those that it needs, so that to look for a name in all before its own loads no more than that one does."""


def __getattr__(name: str) -> Any:
    from importlib import import_module
    from types import ModuleType

    for module in _MODULES if name in __all__ else ():
        found = vars(import_module(f"gyrodata.grading.{module}")).get(name)
        # A module that holds one of its own name is an attribute of its package too.
        if found is not None and not isinstance(found, ModuleType):
            return found
    raise AttributeError(f"module 'gyrodata.grading' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
