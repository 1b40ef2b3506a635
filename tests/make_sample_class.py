"""Make sample_data/class/ from its stated truths; ``python tests/make_sample_class.py``
writes it anew.
"""

import base64
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.append(str(Path(__file__).parent / "support"))

from grading.students_reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet
from simulated_labs import INERTIA

SEED = 14
IMBALANCE = 2e-4  # [N*m]
BIAS = 0.03  # [s]
TARGET = Path(__file__).parent.parent / "sample_data" / "class"
PICTURE = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
"""One pixel."""


class Student(NamedTuple):
    """One student of the class: what Canvas calls the file, what is so, and the
    mistake, of `SLIPS` or none.
    """

    file: str
    truth: str
    slip: str = ""
    fit: str = "with_constant"
    reports: bool = True


STUDENTS = (
    Student("adlernina_101_9001_lab.csv", "right, by a line with a constant"),
    Student(
        "bakertom_102_9002_gyroscope.csv",
        "right, by the mean of M/(φ̇ψ̇)",
        fit="mean_of_ratios",
    ),
    Student(
        "castilloines_103_9003_lab.csv", "the spin in rpm used as rad/s", "rpm_as_rad_s"
    ),
    Student(
        "dubinoleg_104_9004_data.csv",
        "2π missing in the precession rate",
        "two_pi_missing",
    ),
    Student(
        "erikssonmaja_105_9005_lab.csv",
        "grams used as kilograms",
        "g_as_kg",
        "through_origin",
    ),
    Student(
        "farahyusuf_106_9006_lab report.csv", "centimetres used as metres", "cm_as_m"
    ),
    Student(
        "garciapablo_107_9007_lab.csv",
        "the part of a turn forgotten",
        "turns_forgotten",
        "mean_of_ratios",
    ),
    Student(
        "hansenlise_108_9008_lab.csv",
        "g missing in the torque",
        "missing_g",
        "through_origin",
    ),
    Student(
        "itoken_109_9009_lab.csv", "a diameter used as a radius", "diameter_for_radius"
    ),
    Student("moreaulea_113_9013_lab.csv", "right, and nothing reported", reports=False),
    Student(
        "novakeva_LATE_114_9014_lab.csv",
        "right, by a line through the origin; late",
        fit="through_origin",
    ),
)
COPY = Student(
    "jansenpiet_110_9010_lab.csv",
    "the log of adlernina: rows turned round, kg and m, times to 0.1 s",
)
EMPTY = Student("kimsora_111_9011_lab.csv", "an empty file")
NO_LOG = Student("lopezana_112_9012_lab.csv", "a picture named .csv")
README = f"""\
A class, simulated, not measured: nobody here is anybody. Made by tests/make_sample_class.py, seed {SEED}.

Truth of every log: I_zz = {INERTIA} kg*m^2, residual torque {IMBALANCE} N*m, timing bias {BIAS} s.
Errors, all normal: 0.14 s on a time, tachometer 0.2 % and 0.1 % shared, weights 0.2 % each, ruler zero 0.5 mm.
The files are named as in a download from Canvas: name, LATE, number of the student, number of the file.

"""  # noqa: E501


def _report(rows: Sheet, formula: Formula, fit: str) -> str:
    return reported_line(*formula.inertia(rows, fit))


def _copied(rows: Sheet) -> str:
    """Type the log of another once more, so that it looks like one's own."""
    lines = [
        "# g: 9.803 m/s^2",
        "# station: 3",
        _report(rows, RIGHT, "through_origin"),
        "m [kg];x [m];n [rpm];N;t [s]",
    ]
    columns = (rows.mass, rows.position, rows.spin, rows.turns, rows.time)
    for mass, position, spin, turns, time in reversed(list(zip(*columns, strict=True))):
        part = "1" if turns == 1 else f"{round(3 * turns)}/3"
        lines.append(
            f"{mass / 1000:.5f};{position / 100:.4f};{spin:.1f};{part};{time:.1f}"
        )
    return "\n".join(lines) + "\n"


def make() -> dict[str, bytes]:
    """Make every file of the class, by its name."""
    random = np.random.default_rng(SEED)
    sheets = [sheet(random, "mixed", imbalance=IMBALANCE, bias=BIAS) for _ in STUDENTS]
    students = sorted((*STUDENTS, COPY, EMPTY, NO_LOG))
    width = max(len(student.file) for student in students)
    readme = README + "".join(
        f"{student.file:<{width}}  {student.truth}\n" for student in students
    )
    files = {
        EMPTY.file: b"",
        NO_LOG.file: PICTURE,
        COPY.file: _copied(sheets[0]).encode(),
    }
    for student, rows in zip(STUDENTS, sheets, strict=True):
        report = (
            [_report(rows, SLIPS.get(student.slip, RIGHT), student.fit)]
            if student.reports
            else []
        )
        files[student.file] = rows.log("# station: 3", *report).encode()
    return dict(sorted({**files, "README.txt": readme.encode()}.items()))


if __name__ == "__main__":
    TARGET.mkdir(exist_ok=True)
    for name, data in make().items():
        (TARGET / name).write_bytes(data)
