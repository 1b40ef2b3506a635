"""A class in which everything happens, graded, decided on by hand and graded again: the golden text of what is told."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from grading.classes import make_folder
from grading.reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet
from msgspec.structs import replace
from typer.testing import CliRunner

from gyrodata import __version__
from gyrodata.cli import app
from gyrodata.grading import default_rubric_text

LATE = """
[late]
grace = "10 min"
marked = "10 %"
[[late.exception]]
student = "5"
extra = "1 day"
"""
ROSTER = """student,name,section,station,partner
adamsann,Ann Adams,A,2,
3,"Cole, Kim",A,,7
"poe, dan",Dan Poe,B,,
nobody1,Zed Nobody,B,1,
nobody2,,A,,
12,Lou Lee,B,4,"13; 14"
"""
GRADEBOOK = """Student,ID,SIS Login ID,Section,Gyro (77)
    Points Possible,,,,20
"Adams, Ann",1,ann,A,
"Cole, Kim",3,kim,A,12.50
"Poe, Dan",4,dan,B,EX
"Gone, Al",99,al,B,
"""
DESK = """student,what,value,by,why
adamsann,total,18,Kim,agreed
3,inertia,5.5,Kim,
4,hold,,Kim,copied?
9,reported,4.40e-3 ± 0.05e-3 kg m^2,Kim,from the PDF
10,excuse,,,ill
2,partner,1,Kim,they worked together
12,comment,Come and see me.,Kim,
12,comment,Bring the book.,,
7,report,4,Kim,clear
2,report,5,,
6,report,2.5,,
8,report,0,,
12,report,5,,
15,report,"1,5",,
14,report,4.75,Kim,
14,station,Bench 3,,
5,total,,,
"""


def a_log(rows: Sheet, *head: str, formula: Formula = RIGHT) -> str:
    return rows.log(*head, reported_line(*formula.inertia(rows, "through_origin")))


def class_files() -> dict[str, str | bytes]:
    """What Canvas hands out."""
    rows = [sheet(np.random.default_rng(seed), "mixed", noise=1.0 + seed % 3) for seed in range(16)]
    other = replace(rows[1], time=(rows[1].time + 0.11).round(2))
    return {
        "adamsann_1_101_lab.csv": a_log(rows[1], "# station: 1"),
        "bellbob_2_102_lab.csv": a_log(other),
        "colekim_3_103_lab.csv": a_log(rows[3], formula=SLIPS["rpm_as_rad_s"]),
        "poedan_LATE_4_104_lab.csv": a_log(rows[4]),
        "roeeve_LATE_5_105_lab.csv": a_log(rows[5]),
        "fayflo_6_106_lab.csv": a_log(rows[1]).replace("\n", "\r\n"),
        "grogus_7_107_lab.csv": a_log(rows[7]),
        "grogus_7_108_lab-1.csv": a_log(rows[7], "# u_tme: 0.2 s", "# u_tim: 0.2 s"),
        "hoehal_8_109_lab.csv": a_log(rows[8], formula=Formula(answer=1.3)),
        "idaivy_9_110_lab.csv": rows[9].log(),
        "idaivy_9_111_report.pdf": b"%PDF-1.4",
        "jayjon_10_112_lab.csv": "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,400,x,1\n",
        "keykat_11_113_lab.csv": "",
        "leelou_12_114_lab.csv": a_log(rows[12], "# station: 4", formula=SLIPS["g_as_kg + turns_forgotten"]),
        "moemia_13_115_lab.csv": a_log(rows[13]),
        "moemia_13_116_plot.png": b"\x89PNG",
        "neonic_14_117_lab.csv": rows[14].log(),
        "neonic_14_118_answers.md": "I_zz = 4.4e-3 ± 0.1e-3 kg m^2\n",
        "oatott_15_119_lab.csv": a_log(rows[15], "# station: <b>5</b> | x", formula=SLIPS["missing_g"]),
        "README.txt": "x",
    }


class Course:
    """The class, the folder of its grades, and what has been told so far."""

    def __init__(self, home: Path) -> None:
        self.home = home
        self.root = make_folder(home / "class", class_files())
        rows = sheet(np.random.default_rng(13), "mixed", noise=2.0)
        make_folder(home / "last" / "class", {"old/lab.csv": a_log(rows), "new/lab.csv": a_log(rows, "# station: 9")})
        make_folder(home, {
            "rubric.toml": default_rubric_text("manual") + LATE, "roster.csv": ROSTER, "gradebook.csv": GRADEBOOK,
        })  # fmt: skip

    def run(self, *options: str) -> Iterator[str]:
        """Grade, and tell what is printed."""
        files = {name: str(self.home / name) for name in ("rubric.toml", "roster.csv", "gradebook.csv", "last-grades")}
        arguments = [
            "grade", str(self.root), "--rubric", files["rubric.toml"], "--roster", files["roster.csv"],
            "--workers", "0", "--previous", files["last-grades"], *options,
        ]  # fmt: skip
        done = CliRunner().invoke(app, arguments, prog_name="gyro")
        yield f"exit code {done.exit_code}\n{done.stdout}"
        yield f"standard error:\n{done.stderr}"

    def files(self, *names: str) -> Iterator[str]:
        """Tell what stands in the folder of the grades."""
        for name in names:
            text = (self.home / "grades" / name).read_text(encoding="utf-8")
            yield f"-- {name}\n{re.sub('(?s)<style>.*?</style>', '', text)}"

    def told(self, head: str, *parts: Iterator[str]) -> str:
        """Put together, without what is another in each run and release."""
        text = "".join(one if one.endswith("\n") else f"{one}\n" for part in parts for one in part)
        text = re.sub(r"\b[0-9a-f]{12,}\b", "DIGEST", text.replace(str(self.home), "HOME"))
        text = text.replace(f"gyrodata {__version__}", "gyrodata VERSION")
        text = re.sub(r'("version": ?)"[^"]*"', r'\1"VERSION"', text)
        return f"== {head}\n{text}"


TABLES = ("grades.csv", "desk-todo.csv", "flags.csv", "canvas.csv")


def graded(home: Path) -> tuple[Course, Iterator[str]]:
    """Grade for the first time; give what is told of it too."""
    course = Course(home)
    last = ["grade", str(home / "last" / "class"), "--out", str(home / "last-grades"), "--workers", "0"]
    assert CliRunner().invoke(app, last).exit_code == 0
    return course, course.run("--out", str(home / "grades"), "--gradebook", str(home / "gradebook.csv"))


def at_first(home: Path) -> Iterator[str]:
    """Grade, and grade again where nothing has changed."""
    course, told = graded(home)
    yield course.told("at first", told, course.files(*TABLES, "class.html"))
    yield course.told("nothing new", course.run("--out", str(home / "grades")), course.files("desk-todo.csv"))
    lines = (line[:150] for part in course.run("--format", "ndjson", "-q") for line in part.splitlines())
    yield course.told("ndjson", lines)


def decided_on(home: Path) -> Iterator[str]:
    """Decide on a class, hand in again, write into what was written, and grade again."""
    course, told = graded(home)
    assert len(list(told)) == 2
    grades, options = home / "grades", ("--out", str(home / "grades"), "--gradebook", str(home / "gradebook.csv"))
    (grades / "desk.csv").write_text(DESK, encoding="utf-8")
    table = (grades / "grades.csv").read_text(encoding="utf-8").splitlines()
    table = [f"{line},{'remark' if line.startswith('student') else 'nice' * line.startswith('13,')}" for line in table]
    changed = [re.sub(r"(,graded,|,so far,)[\d.]+", r"\g<1>3.25", line) if line[:2] == "8," else line for line in table]
    (grades / "grades.csv").write_text("\n".join(changed) + "\n", encoding="utf-8")
    rows = sheet(np.random.default_rng(3), "mixed")
    (home / "class" / "colekim_3_103_lab.csv").write_text(a_log(rows), encoding="utf-8")
    page = grades / "feedback" / "hoehal_8_109_lab.md"
    page.write_text(page.read_text(encoding="utf-8") + "nice\n", encoding="utf-8")
    yield course.told("what would change", course.run("--dry-run", *options))
    pages = sorted(f"feedback/{path.name}" for path in (grades / "feedback").glob("*.md"))
    yield course.told("decided on", course.run(*options), course.files(*TABLES, "class.html", *pages))
    yield course.told("json", course.run("--format", "json", "--quiet", *options))
