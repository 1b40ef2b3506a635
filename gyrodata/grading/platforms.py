"""The platforms of a class, one record each: how the names of its files come in, and how grades go back.

Canvas: `lib/content_zipper.rb`, `lib/gradebook_importer.rb` and `lib/gradebook_exporter.rb` of instructure/canvas-lms.
Moodle: `mod/assign/classes/downloader.php`, `feedback/file/importziplib.php`, `feedback/offline/importgradeslib.php`
and `locallib.php` of moodle/moodle. Gradescope: gradescope-autograders.readthedocs.io. Blackboard and Gradescope do not
publish their source: their names are those of downloads.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from msgspec import Struct

from gyrodata.diagnostics import NO_BLACKBOARD_GRADE_CENTER, NO_CANVAS_GRADEBOOK, NO_MOODLE_WORKSHEET


class Book(Struct, frozen=True):
    """The sheet of grades that a platform exports, to be filled and given back."""

    noun: str  # what the platform calls it
    code: str  # diagnostic of a sheet that is none, and how that is told
    none: str
    export: str  # how to get one, a hint
    # of a sheet with a column for each assignment
    begins: str = ""  # pattern of how the first row begins, its cells parted by tabs
    maximum: str = ""  # the name of the row of possible points; "": they are in the assignment's title
    # pattern of an assignment's title and, behind a line feed, its cell in the row of points possible;
    # groups: title, number, most (points possible), locked (why it takes no points)
    assignment: str = ""
    unlock: str = ""  # what to do where it takes none, a hint
    known_by: tuple[tuple[str, tuple[str, ...]], ...] = ()  # titles of the columns of students, and the ids in each


class Platform(Struct, frozen=True):
    """How one platform names the files of a class, and takes grades back."""

    name: str
    sample: str  # name of one file, for messages
    shapes: tuple[re.Pattern[str], ...] = ()  # of a whole name below the class; groups as in `ParsedName`, and its ids
    book: Book | None = None  # None: grades go back by hand, from ``grades.csv``


def _shapes(*texts: str) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile(text, re.DOTALL) for text in texts)


_UPLOAD = r"_(?:\d+_|(?=(?:text|link)\.html\Z))(?P<file>[^/]+)"  # a file's number, or what was typed in there

# Names are parsed from the number, because a name may contain anything but an underscore. The first platform that fits
# a name is used.
PLATFORMS: Mapping[str, Platform] = {
    platform.name: platform
    for platform in (
        Platform(
            "moodle",
            "Jane Doe_1234567_assignsubmission_file/lab.csv",
            _shapes(
                r"(?P<stem>(?P<name>[^/]*?)_(?P<moodle>\d+)_assignsubmission_[a-z]+_?)/(?P<file>.+)",
                r"(?P<name>[^/]*?)_(?P<moodle>\d+)_assignsubmission_[a-z]+_(?P<file>[^/]+)",
            ),
            book=Book(
                noun="worksheet",
                code=NO_MOODLE_WORKSHEET,
                none="is no Moodle grading worksheet",
                export="in the assignment: View all submissions, Download grading worksheet; give that file as it is",
            ),
        ),
        Platform(
            "blackboard",
            "Gyroscope lab_jdoe_attempt_2026-03-09-14-05-59_lab.csv",
            _shapes(
                r"(?P<owner>[^/]*_(?P<username>[^_/]+))_attempt_(?P<stamp>\d{4}(?:-\d\d){5})"
                r"(?:_(?P<file>[^/]+)|\.txt)"
            ),
            book=Book(
                noun="Grade Center",
                code=NO_BLACKBOARD_GRADE_CENTER,
                none='is no Blackboard Grade Center: it does not begin with "Last Name", "First Name" and "Username"',
                export="in Blackboard, with English as its language: Work Offline, Download; give that file as it is",
                begins=r"Last Name\tFirst Name\tUsername\t",
                # Totals have "up to" before their points: Blackboard works them out, and takes none back.
                assignment=r"(?P<title>.*) \[Total Pts: (?P<most>[\d.,]+)(?: Score| (?P<locked>[^\]]+))?\]"
                r" ?\|(?P<number>\d+)\n",
                unlock="set its Primary Display in Blackboard to Score and export again",
                known_by=(("Username", ("username",)), ("Student ID", ("sid",))),
            ),
        ),
        Platform(
            "gradescope",
            "submission_123456789/lab.csv beside submission_metadata.yml",
            _shapes(r"(?P<stem>submission_(?P<gradescope>\d+))/(?P<file>.+)"),
        ),
        Platform(
            "canvas",
            "doejane_9876_5432_lab.csv",
            _shapes(
                rf"(?P<late>LATE_)?anon_(?P<canvas_anonymous>[0-9A-Za-z]+){_UPLOAD}",
                rf"(?P<name>[^/]*?)(?P<late>_LATE|_late)?_(?P<canvas>\d+){_UPLOAD}",
            ),
            book=Book(
                noun="gradebook",
                code=NO_CANVAS_GRADEBOOK,
                none='is no Canvas gradebook: it does not begin with "Student" and "ID"',
                export="in Canvas: Grades, Export, Export Entire Gradebook; give that file as it is",
                maximum="Points Possible",
                begins=r"(?:Student|LastName)[^\t]*\t(?:[^\t]*\t)?ID(?:\t|$)",
                assignment=r"(?P<title>.*) \((?P<number>\d+)\)\n(?P<most>(?:.*(?P<locked>read.only))?.*)",
                unlock="unlock it in Canvas and export again",
                known_by=(("ID", ("canvas",)), ("SIS User ID", ("sid",)), ("SIS Login ID", ("username", "email"))),
            ),
        ),
        Platform("folder", "jdoe/lab.csv or jdoe.csv"),
    )
}
"""All of them; the last has no names of its own."""

NAMED = tuple(name for name, platform in PLATFORMS.items() if platform.shapes)  # those that are known by their names
