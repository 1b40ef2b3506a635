"""Who handed in what: a folder or zip of a class becomes `Submission`s, one for each student or group."""

from gyrodata.grading.submissions.archives import list_files, read_file, size_text
from gyrodata.grading.submissions.find import Attempts, Submission, Submissions, find_submissions
from gyrodata.grading.submissions.names import shown

__all__ = [
    "Attempts",
    "Submission",
    "Submissions",
    "find_submissions",
    "list_files",
    "read_file",
    "shown",
    "size_text",
]
