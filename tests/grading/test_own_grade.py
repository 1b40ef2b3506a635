"""A student cannot raise the own grade: not by unseen text, a second answer,
statements, or somebody else's log.
"""

import io
import json
import zipfile
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import cycle
from pathlib import Path
from typing import Any

import make_examples
import numpy as np
import openpyxl
import pytest
from classes.class_cells import grade, gyro
from classes.drawn import FITS, TITLES, USUAL, draw
from grading.students_reports import reported_line
from msgspec.structs import replace

from gyrodata.grading.rubric import default_rubric_text
from gyrodata.quantities.error_sources import SOURCES

STUDENT = draw(3, 21, replace(USUAL, hand=0.08))
OWN = STUDENT.answer()[0]
OFF = reported_line(1.17 * OWN, 0.012 * OWN)
ROWS = STUDENT.log().splitlines()[2:]
WRONG = "I_zz = 5.20e-3 ± 0.06e-3 kg m^2"
RIGHT = f"Final result: I_zz = {STUDENT.answer()[0]:.6f} ± 0.00006 kg m^2"


def alone(
    report: str, content: str | bytes, log: str = STUDENT.log()
) -> dict[str, Any]:
    """Grade one student who hands in a log and a report."""
    files: Mapping[str, str | bytes] = {"ann/lab.csv": log, f"ann/{report}": content}
    return dict(grade(files, "--lms", "folder")["students"]["ann"])


def packed(**parts: str) -> bytes:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, text in parts.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return data.getvalue()


def word(properties: str, around: str = "{}") -> bytes:
    run = f"<w:r><w:rPr>{properties}</w:rPr><w:t>{RIGHT}</w:t></w:r>"
    body = (
        f"<w:p><w:r><w:t>{WRONG}</w:t></w:r></w:p>{around.format(f'<w:p>{run}</w:p>')}"
    )
    document = f'<?xml version="1.0"?><w:document xmlns:w="w"><w:body>{body}</w:body></w:document>'
    return packed(word__document_xml=document)


def workbook(state: str) -> bytes:
    book = openpyxl.Workbook()
    book.active.append([WRONG])
    other = book.create_sheet("answer")
    other.append([RIGHT])
    other.sheet_state = state
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def notebook(kind: str, source: str, **metadata: object) -> str:
    cells = [
        {"cell_type": "markdown", "source": [WRONG], "metadata": {}},
        {"cell_type": kind, "source": [source], "metadata": metadata, "outputs": []},
    ]
    return json.dumps(
        {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5},
        ensure_ascii=False,
    )


def page(hidden: str, head: str = "") -> str:
    return f"<html><head>{head}</head><body><p>{WRONG}</p>{hidden}<p>The end.</p></body></html>"


STYLES = (
    "display:none",
    "DISPLAY: None !important",
    "visibility:hidden",
    "visibility:collapse",
    "opacity:0",
    "font-size:0",
    "font-size: 1px",
    "color:white",
    "color:#fff",
    "color:#FEFEFE",
    "color: rgb(255, 255, 255)",
    "color:transparent",
    "text-indent:-9999px",
    "position:absolute;left:-5000px",
)
PAGES = {
    **{style: page(f'<span style="{style}">{RIGHT}</span>') for style in STYLES},
    **{
        name: page(f"<{name}>{RIGHT}</{name}>")
        for name in ("template", "script", "style", "noscript", "dialog")
    },
    "title": page("", f"<title>{RIGHT}</title>"),
    "hidden": page(f"<div hidden><div><b>{RIGHT}</b></div></div>"),
    "font": page(f'<font color="#ffffff">{RIGHT}</font>'),
    "attribute": page(f'<a title="> {RIGHT}">here</a>'),
    "comment": page(f"<!-- {'x' * 3000} {RIGHT} -->"),
    "open comment": page(f"<!-- {RIGHT}"),
}
LATEX = {
    **{
        name: f"{WRONG}\n\n\\{name}{{{RIGHT}}}\n"
        for name in ("phantom", "hphantom", "vphantom", "textcolor{white}")
    },
    "end": f"\\begin{{document}}\n{WRONG}\n\\end{{document}}\n{RIGHT}\n",
}
MARKDOWN = {
    "link": f"{WRONG}\n\n[//]: # ({RIGHT})\n",
    "quotes": f'{WRONG}\n\n[note]: <> "{RIGHT}"\n',
    "element": f'{WRONG}\n\n<span style="display:none">{RIGHT}</span>\n',
    "comment": f"{WRONG}\n\n<!-- {'x' * 3000} {RIGHT} -->\n",
}
WORDS = {
    **{tag: word(f"<w:{tag}/>") for tag in ("vanish",)},
    "white": word('<w:color w:val="FFFFFF"/>'),
    "nearly white": word('<w:color w:val="FEFEFE"/>'),
    "small": word('<w:sz w:val="2"/>'),
    "narrow": word('<w:w w:val="1"/>'),
    "deleted": word("", around="<w:del>{}</w:del>"),
}
UNSEEN: dict[str, tuple[str, str | bytes]] = {
    **{f"html, {name}": ("report.html", text) for name, text in PAGES.items()},
    **{f"tex, {name}": ("report.tex", text) for name, text in LATEX.items()},
    **{f"md, {name}": ("report.md", text) for name, text in MARKDOWN.items()},
    **{f"docx, {name}": ("report.docx", text) for name, text in WORDS.items()},
    **{
        f"xlsx, {state}": ("report.xlsx", workbook(state))
        for state in ("hidden", "veryHidden")
    },
    "ipynb, raw": ("report.ipynb", notebook("raw", RIGHT)),
    "ipynb, source": (
        "report.ipynb",
        notebook("code", f"# {RIGHT}", jupyter={"source_hidden": True}),
    ),
    "ipynb, element": ("report.ipynb", notebook("markdown", f"<i hidden>{RIGHT}</i>")),
    "txt, blanks": ("report.txt", f"{WRONG}\n{' ' * 900}{RIGHT}\n"),
    "txt, behind": ("report.txt", f"{WRONG}{' ' * 900}{RIGHT}\n"),
    "md, blanks": ("report.md", f"{WRONG}\n\n{' ' * 900}{RIGHT}\n"),
}


@pytest.fixture(scope="module")
def hidden() -> dict[str, Any]:
    """Everybody's grade in a class with each way to hide the answer, beside a wrong one
    and, if it is text, alone.
    """
    files: dict[str, str | bytes] = {
        "wrong/lab.csv": STUDENT.log(),
        "wrong/report.txt": WRONG,
    }
    for number, (name, content) in enumerate(UNSEEN.values()):
        files |= {
            f"beside{number}/lab.csv": STUDENT.log(),
            f"beside{number}/{name}": content,
        }
        if isinstance(content, str):
            alone = content.replace(WRONG, "Our report.")
            files |= {
                f"alone{number}/lab.csv": STUDENT.log(),
                f"alone{number}/{name}": alone,
            }
    return dict(grade(files, "--lms", "folder")["students"])


@pytest.mark.slow
@pytest.mark.parametrize("way", UNSEEN)
def test_unseen_text_is_no_answer(way: str, hidden: dict[str, Any]) -> None:
    number = list(UNSEEN).index(way)
    student = hidden[f"beside{number}"]
    assert student["reported"]["value"] == pytest.approx(5.2e-3)
    assert student["points"] == hidden["wrong"]["points"]
    assert not any("two answers" in look for look in student["look"])
    if isinstance(UNSEEN[way][1], str):
        assert hidden[f"alone{number}"]["status"] == "not graded"


@pytest.mark.slow
def test_unseen_answer_in_the_log_is_none() -> None:
    book = openpyxl.Workbook()
    for row in ROWS:
        book.active.append([*map(float, row.split(",")[:4]), row.split(",")[4]])
    book.active.insert_rows(1)
    for at, title in enumerate(TITLES.split(","), 1):
        book.active.cell(1, at, title)
    other = book.create_sheet("answer")
    other.append([f"# reported_inertia: {RIGHT.split('= ')[1]}"])
    logs: dict[str, str | bytes] = {
        "blanks/lab.csv": f"{' ' * 900}# reported_inertia: {OWN:.6f} kg m^2\n{STUDENT.log()}"
    }
    for state in ("visible", "hidden", "veryHidden"):
        other.sheet_state = state
        data = io.BytesIO()
        book.save(data)
        logs[f"{state}/lab.xlsx"] = data.getvalue()
    found = grade(logs, "--lms", "folder")["students"]
    assert {key: one["status"] for key, one in found.items()} == {
        "blanks": "not graded",
        "visible": "graded",
        "hidden": "not graded",
        "veryHidden": "not graded",
    }


SEEN = {
    "white on black": (
        "report.html",
        page(f'<p style="background:#111"><b style="color:white">{RIGHT}</b></p>'),
    ),
    "white on a picture": (
        "report.html",
        page(f'<p style="background:url(a.png);color:#fff">{RIGHT}</p>'),
    ),
    "white on red": (
        "report.html",
        page(f'<div style="background:#f44336;color:white">{RIGHT}</div>'),
    ),
    "white on a dark page": (
        "report.html",
        page(
            f'<h1 style="color:#fff">{RIGHT}</h1>',
            "<style>body { background: #222 }</style>",
        ),
    ),
    "white in a dark cell": (
        "report.docx",
        word(
            '<w:color w:val="FFFFFF"/>',
            '<w:tc><w:tcPr><w:shd w:fill="1F3864"/></w:tcPr>{}</w:tc>',
        ),
    ),
    "white in a box": (
        "report.tex",
        f"\\colorbox{{blue}}{{\\textcolor{{white}}{{{RIGHT}}}}}\n",
    ),
    "style for printers": (
        "report.html",
        page(RIGHT, "<style>@media print { p, body { display: none } }</style>"),
    ),
    "hidden before": ("report.html", page(f"<p hidden>no<p>{RIGHT}</p>")),
    "word, white on a shade": (
        "report.docx",
        word('<w:color w:val="FFFFFF"/><w:shd w:fill="000000"/>'),
    ),
    "word, hidden end of a paragraph": (
        "report.docx",
        word("", "<w:pPr><w:rPr><w:vanish/></w:rPr></w:pPr>{}"),
    ),
    "word, vanish off": ("report.docx", word('<w:vanish w:val="0"/>')),
    "red": ("report.html", page(f'<b style="color:rgb(255,0,0)">{RIGHT}</b>')),
    "light on black": (
        "report.html",
        page(f'<p style="background:#111"><b style="color:#eee">{RIGHT}</b></p>'),
    ),
    "black": ("report.tex", f"\\textcolor{{blue}}{{{RIGHT}}}\n"),
    "link that is none": ("report.md", f"[note]: {RIGHT}\n"),
    "visible sheet": ("report.xlsx", workbook("visible")),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", SEEN)
def test_text_that_a_person_sees_is_read(way: str) -> None:
    name, content = SEEN[way]
    content = (
        content.replace(WRONG, "Our report.") if isinstance(content, str) else content
    )
    student = alone(name, content)
    assert student["reported"]["text"] in RIGHT
    assert not any("may be hidden" in look for look in student["look"])


TWICE: dict[str, Callable[[], dict[str, Any]]] = {
    "text": lambda: alone("report.txt", f"{WRONG}\n{RIGHT}\n"),
    "html": lambda: alone("report.html", page(f"<p>{RIGHT}</p>")),
    "two files": lambda: grade_with(
        {"ann/a.txt": WRONG, "ann/b.md": RIGHT}, STUDENT.log()
    ),
    "log and text": lambda: alone(
        "report.txt", WRONG, STUDENT.log(f"# reported_inertia: {RIGHT.split('= ')[1]}")
    ),
    "two lines": lambda: alone(
        "a.png",
        "",
        STUDENT.log(f"# {WRONG}", f"# reported_inertia: {RIGHT.split('= ')[1]}"),
    ),
    "below": lambda: alone(
        "a.png",
        "",
        STUDENT.log(f"# reported_inertia: {RIGHT.split('= ')[1]}", foot=f"# {WRONG}\n"),
    ),
    "without u": lambda: alone(
        "report.txt", f"{WRONG.replace(' ± 0.06e-3', '')}\n{RIGHT}\n"
    ),
    "final": lambda: grade_with(
        {"ann/report.txt": WRONG, "ann/final_v99.txt": RIGHT}, STUDENT.log()
    ),
}


def grade_with(files: Mapping[str, str], log: str) -> dict[str, Any]:
    return dict(
        grade({"ann/lab.csv": log, **files}, "--lms", "folder")["students"]["ann"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("place", TWICE)
def test_two_answers_that_differ_are_a_question(place: str) -> None:
    student = TWICE[place]()
    questions = [student["why"]] if student["status"] == "not graded" else []
    questions += [look for look in student["look"] if look.startswith("two answers")]
    (question,) = questions
    assert "5.20e-3" in question or "reported twice" in question


def test_answers_that_agree_are_no_question() -> None:
    value = STUDENT.answer()[0]
    near = f"mean: I_zz = {1.01 * value:.6f} ± 0.00006 kg m^2\n{RIGHT}\n"
    assert alone("report.txt", near)["look"] == []


# --- statements of the log ---


def with_columns(titles: str, cells: Callable[[list[str]], list[str]]) -> str:
    """Write the log of the student with other columns."""
    return (
        "\n".join([titles, *(",".join(cells(row.split(","))) for row in ROWS)]) + "\n"
    )


def newton(grams: str) -> float:
    return 9.803e-3 * float(grams)


BY_SOURCE = {
    "precession_rate": with_columns(
        "mass [g],position [cm],spin [rpm],precession_rate [rad/s]",
        lambda c: [*c[:3], f"{6.2831853 * float(Fraction(c[4])) / float(c[3]):.4f}"],
    ),
    "force": with_columns(
        "force [N],position [cm],spin [rpm],time [s],turns",
        lambda c: [f"{newton(c[0]):.4f}", *c[1:]],
    ),
    "torque": with_columns(
        "torque [N m],spin [rpm],time [s],turns",
        lambda c: [f"{newton(c[0]) * float(c[1]) / 100:.6f}", *c[2:]],
    ),
    "decay_exponent": with_columns(
        "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns",
        lambda c: [
            *c[:2],
            f"{1.3 * float(c[2]):.0f}",
            f"{float(c[2]) / 1.3:.0f}",
            *c[3:],
        ],
    ),
    "pitch": with_columns(
        "pitch [deg],mass [g],position [cm],spin [rpm],time [s],turns",
        lambda c: ["1", *c],
    ),
    "transverse_inertia": "# transverse_inertia: 6e-3 kg m^2\n"
    + with_columns(
        "pitch [deg],mass [g],position [cm],spin [rpm],time [s],turns",
        lambda c: ["25", *c],
    ),
    "weight_diameter": with_columns(
        "weight_diameter [mm],mass [g],position [cm],spin [rpm],time [s],turns",
        lambda c: ["40", *c],
    ),
}
"""A log for each source of error that the usual one does not have."""


WIDE = {
    **dict.fromkeys(SOURCES, "60 %"),
    "time": "5 s",
    "time_bias": "3 s",
    "angle": "20 deg",
    "spin_delay": "60 s",
    "decay_exponent": "9",
    "position": "4 cm",
    "position_zero": "5 cm",
    "pitch": "30 deg",
    "spin": "60 rpm",
}

BALANCES = ["", "# balance: touched\n", "# balance: untouched\n"]

WIDENING = (
    *(
        "precession_rate",
        "time",
        "spin",
        "spin_scale",
        "spin_delay",
        "mass",
        "mass_scale",
    ),
    *("force", "torque", "position", "position_zero", "g"),
)


@pytest.fixture(scope="module")
def stated() -> dict[str, Any]:
    """The grades of wrong answers, from logs without and with a statement for each
    source of error, and every other one of the balance.
    """
    files: dict[str, str | bytes] = {}
    for key, balance in zip(SOURCES, cycle(BALANCES[:2])):
        log = f"# motion: steady\n{balance}{BY_SOURCE.get(key, STUDENT.log())}"
        files |= {
            f"{key}-plain/lab.csv": f"{OFF}\n{log}",
            f"{key}-wide/lab.csv": f"# u_{key}: {WIDE[key]}\n{OFF}\n{log}",
        }
    return dict(grade(files, "--lms", "folder")["students"])


@pytest.mark.slow
@pytest.mark.parametrize("key", SOURCES)
def test_no_statement_makes_a_wrong_answer_right(
    key: str, stated: dict[str, Any]
) -> None:
    plain, wide = stated[f"{key}-plain"], stated[f"{key}-wide"]
    assert plain["status"] == wide["status"] == "graded"
    assert wide["points"] <= plain["points"]
    asked = [look for look in wide["look"] if "far over the usual" in look]
    # The others change u of this log by less than half of it.
    assert bool(asked) == (key in WIDENING)
    assert all(f"u_{key}" in look for look in asked)
    assert any("no common mistake explains it" in look for look in wide["look"])
    assert not any("far over the usual" in look for look in plain["look"])


CELLS = {
    "column": with_columns(
        "mass [g],position [cm],spin [rpm],time [s],u_time [s],turns",
        lambda c: [*c[:4], "5", c[4]],
    ),
    "column of many turns": with_columns(
        "mass [g],position [cm],spin [rpm],time [s],u_time [s],turns",
        lambda c: [*c[:3], f"{12 * float(c[3]):.2f}", "5", f"{12 * Fraction(c[4])}"],
    ),
    "cell": with_columns(
        "mass [g],position [cm],spin [rpm],time [s],turns",
        lambda c: [f"{c[0]} ± 10", *c[1:]],
    ),
    "header": with_columns(
        "mass [g],position [cm] ± 4,spin [rpm],time [s],turns", list
    ),
    "origin": "# position_from: surface\n# ball_diameter: 10.16 ± 5 cm\n"
    + with_columns(
        "mass [g],position [cm],spin [rpm],time [s],turns",
        lambda c: [c[0], f"{float(c[1]) - 5.08:.2f}", *c[2:]],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("place", CELLS)
def test_wide_uncertainty_is_found_wherever_it_is_stated(place: str) -> None:
    files = {
        "plain/lab.csv": f"{OFF}\n{STUDENT.log()}",
        "wide/lab.csv": f"{OFF}\n{CELLS[place]}",
    }
    students = grade(files, "--lms", "folder")["students"]
    assert students["wide"]["points"] <= students["plain"]["points"]
    assert any("far over the usual" in look for look in students["wide"]["look"])


def with_turns(factor: float) -> str:
    return with_columns(TITLES, lambda c: [*c[:4], f"{factor * Fraction(c[4]):.4f}"])


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.8547, 0.93, 1.17])
def test_unusual_number_of_turns_is_a_question(factor: float) -> None:
    """Such a number makes a wrong answer agree with the runs."""
    answer = reported_line(factor * OWN, 0.012 * OWN)
    (one,) = grade(
        {"ann/lab.csv": f"{answer}\n{with_turns(factor)}"}, "--lms", "folder"
    )["students"].values()
    assert any("unusual number of turns" in look for look in one["look"])


def with_days(factors: Callable[[int], float], day: Callable[[int], str]) -> str:
    """The times of each row are changed by a factor, and the row belongs to a day."""
    cells = [row.split(",") for row in ROWS]
    lines = [
        ",".join([*row[:3], f"{float(row[3]) * factors(at):.2f}", row[4], day(at)])
        for at, row in enumerate(cells)
    ]
    return "\n".join(["# motion: steady", f"{TITLES},day", *lines]) + "\n"


CLASS: dict[str, str | bytes] = {
    f"s{i}/lab.csv": f"# station: 1\n{TITLES}\n{student.log().split(TITLES)[1]}"
    for i, student in enumerate(
        draw(STUDENT.number, seed, replace(USUAL, hand=0.08, missed=0.2))
        for seed in range(21, 40)
    )
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "log",
    [
        with_columns(
            TITLES,
            lambda c: [
                *c[:4],
                f"{float(Fraction(c[4])) / 1.17 + float(c[2]) / 1e5:.4f}",
            ],
        ),
        with_columns(TITLES, lambda c: [*c[:3], f"{1.17 * float(c[3]):.2f}", c[4]]),
        with_days(lambda at: 1.17, lambda at: f"d{at // 3}"),
    ],
)
def test_log_written_to_fit_a_wrong_answer_is_a_question(log: str) -> None:
    files = {**CLASS, "ann/lab.csv": f"# station: 1\n{OFF}\n{log}"}
    student = grade(files, "--lms", "folder")["students"]["ann"]
    assert points(student)["own_data"] == 6
    assert points(student)["reference"] == 0
    assert any("the log's own I_zz is" in look for look in student["look"])


@pytest.mark.slow
def test_days_make_no_wrong_answer_right() -> None:
    """The weights contradict each other, unless each has a day of its own."""
    by_weight = (1.3, 0.8, 1.0)
    answers = [reported_line(f * OWN, 0.012 * OWN) for f in (0.85, 1.1)]
    files: dict[str, str | bytes] = {}
    for number, answer in enumerate(answers):
        for name, days in (("plain", 9), ("days", 3)):
            log = with_days(
                lambda at: by_weight[at // 3], lambda at, days=days: f"d{at // days}"
            )
            files[f"{name}{number}/lab.csv"] = f"{answer}\n{log}"
    students = grade(files, "--lms", "folder")["students"]
    for number in range(len(answers)):
        plain, days = students[f"plain{number}"], students[f"days{number}"]
        assert points(days)["own_data"] <= points(plain)["own_data"] + 0.1


@pytest.mark.slow
def test_ten_degrees_less_than_a_turn_is_a_question() -> None:
    log = with_columns(
        TITLES,
        lambda c: [*c[:3], f"{float(c[3]) * 0.9722 / Fraction(c[4]):.2f}", "0.9722"],
    )
    answer = reported_line(OWN, 0.012 * OWN)
    (one,) = grade({"ann/lab.csv": f"{answer}\n{log}"}, "--lms", "folder")[
        "students"
    ].values()
    assert one["look"] == ["9 runs have an unusual number of turns: 0.9722"]


@pytest.mark.parametrize(
    "log",
    [
        with_turns(1.0),
        with_columns(TITLES, lambda c: [*c[:4], f"{float(Fraction(c[4])):.2f}"]),
        with_columns(
            "mass [g],position [cm],spin [rpm],time [s],angle [deg]",
            lambda c: [*c[:4], f"{360 * Fraction(c[4])}"],
        ),
    ],
)
def test_usual_number_of_turns_is_no_question(log: str) -> None:
    answer = reported_line(*STUDENT.answer())
    (one,) = grade({"ann/lab.csv": f"{answer}\n{log}"}, "--lms", "folder")[
        "students"
    ].values()
    assert one["look"] == []


@pytest.mark.slow
def test_refusal_is_not_switched_off() -> None:
    rows = [row.split(",") for row in ROWS]
    bent = [
        f"{row[0]},{row[1]},{row[2]},{float(row[3]) * (1.5, 0.6, 1.0)[i % 3]:.2f},{row[4]}"
        for i, row in enumerate(rows)
    ]
    log = "\n".join(["mass [g],position [cm],spin [rpm],time [s],turns", *bent]) + "\n"
    answer = reported_line(OWN, 0.012 * OWN)
    files = {
        "a/lab.csv": f"{answer}\n{log}",
        "b/lab.csv": f"# u_time: 20 s\n{answer}\n{log}",
    }
    plain, wide = grade(files, "--lms", "folder")["students"].values()
    assert wide["status"] == plain["status"]
    constancy = [
        mark["points"]
        for one in (plain, wide)
        for mark in one["marks"]
        if mark["check"] == "constancy"
    ]
    assert constancy[0] == constancy[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bench", "stated_u", "asks"),
    [("", "0.5 s", False), ("", "0.9 s", True), ("0.5 s", "1.1 s", False)],
)
def test_usual_uncertainty_is_that_of_the_bench(
    bench: str, stated_u: str, asks: bool, tmp_path: Path
) -> None:
    rubric = default_rubric_text()
    if bench:
        rubric = rubric.replace(
            '[bench]\nfrom = "class"', f'[bench]\nu_time = "{bench}"'
        )
    (tmp_path / "rubric.toml").write_text(rubric, encoding="utf-8")
    log = STUDENT.log(f"# u_time: {stated_u}", reported_line(*STUDENT.answer()))
    (student,) = grade({"ann/lab.csv": log}, "--rubric", tmp_path / "rubric.toml")[
        "students"
    ].values()
    assert any("u_time" in look for look in student["look"]) == asks


# --- logs of somebody else ---


def simulated() -> str:
    spins = "200,400,600rpm"
    return gyro(
        "simulate",
        "--weights",
        "20g,40g,60g",
        "--position",
        "15cm",
        "--spins",
        spins,
        "--seed",
        "4",
    ).stdout


def flags_of(log: str | bytes, *others: str) -> list[tuple[str, list[str]]]:
    files = {
        "zoe/lab.csv": log,
        **{f"s{i}/lab.csv": one for i, one in enumerate(others)},
    }
    flags = grade(files, "--lms", "folder")["flags"]
    return [
        (flag["kind"], flag["previous"]) for flag in flags if "zoe" in flag["students"]
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrap",
    [
        str,
        lambda text: text.replace("# Simulated", "#SIMULATED "),
        lambda text: f"# a: b\n{text}",
        lambda text: renamed(text, "# simulated data"),
        lambda text: renamed(text, "# these are simulated readings, never measured"),
        lambda text: renamed(text, "# generated by gyro simulate --seed 4"),
        lambda text: renamed(text, "# Die Daten sind simuliert."),
    ],
)
def test_simulated_log_is_flagged(wrap: Callable[[str], str]) -> None:
    assert ("simulated", []) in flags_of(wrap(simulated()))


def renamed(log: str, remark: str) -> str:
    """Write a log with another remark in place of the one of ``gyro simulate``."""
    rows = [line for line in log.splitlines() if "imulated" not in line]
    return "\n".join([remark, *rows])


@pytest.mark.slow
@pytest.mark.parametrize(
    "remark",
    [
        "# simulated on paper, then measured",
        "# measured, not simulated",
        "# not simulated",
        "# compare with the simulation of the lecture",
    ],
)
def test_measured_log_is_not_flagged(remark: str) -> None:
    assert flags_of(STUDENT.log(remark)) == []


@pytest.mark.slow
def test_fingerprints_are_those_of_the_examples() -> None:
    assert make_examples.TARGET.read_text(encoding="utf-8") == make_examples.make()


SAMPLES = [
    name
    for name in json.loads(make_examples.TARGET.read_bytes())
    if name.startswith("sample_data")
]


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES[::3])
def test_copy_of_an_example_is_flagged(name: str) -> None:
    text = (make_examples.ROOT / name).read_text(encoding="utf-8")
    rows = [line for line in text.splitlines(keepends=True) if "imulated" not in line]
    honest = [draw(i, 30).log() for i in range(3)]
    flags = flags_of("".join(rows), *honest)
    assert any(kind == "shared rows" and previous for kind, previous in flags)


@pytest.mark.slow
def test_honest_classes_do_not_look_like_examples() -> None:
    for step in (1, 5, 10):
        students = [
            draw(i, 31, replace(USUAL, rpm_step=step, decimals=1)) for i in range(8)
        ]
        flags = grade(
            {f"s{one.number}/lab.csv": one.log() for one in students}, "--lms", "folder"
        )["flags"]
        assert [flag for flag in flags if flag["previous"]] == []


# --- digits, and mistakes ---


def points(student: Mapping[str, Any]) -> dict[str, float]:
    return {mark["check"]: mark["points"] for mark in student["marks"]}


def answered(*texts: str) -> list[dict[str, Any]]:
    files = {
        f"s{i:03d}/lab.csv": f"# reported_inertia: {text} kg m^2\n{STUDENT.log()}"
        for i, text in enumerate(texts)
    }
    return list(grade(files, "--lms", "folder")["students"].values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "balance"), zip([0.6, 0.88, 0.9, 1.12, 1.3], cycle(BALANCES))
)
def test_fewer_digits_never_give_more_points(factor: float, balance: str) -> None:
    """The answers have one digit, of runs with an I_zz that is off by this factor."""
    rows = replace(STUDENT.rows, mass=STUDENT.rows.mass * 0.005 / OWN / factor)
    student = replace(STUDENT, rows=replace(rows, mass=rows.mass.round(2)))
    texts = ["5.00e-3 ± 0.06e-3", "0.005 ± 0.001", "0.005", "5e-3 ± 1e-3"]
    files = {
        f"s{i}/lab.csv": f"{balance}# reported_inertia: {text} kg m^2\n{student.log()}"
        for i, text in enumerate(texts)
    }
    fine, *coarse = grade(files, "--lms", "folder")["students"].values()
    for one in coarse:
        assert points(one)["own_data"] <= points(fine)["own_data"]
        assert one["points"] <= fine["points"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "balance"), zip([0.1, 0.5, 2.0, 9.803, 60.0, 1000.0], cycle(BALANCES))
)
def test_no_mistake_is_named_for_one_digit(factor: float, balance: str) -> None:
    """An answer of one digit agrees with many mistakes by chance."""
    power = int(np.floor(np.log10(factor * OWN)))
    digit = round(factor * OWN / 10.0**power)
    log = f"{balance}{STUDENT.log()}"
    for text in (f"{digit}e{power} ± 1e{power}", f"{digit * 10.0**power:.7g}"):
        (one,) = grade({"ann/lab.csv": f"# reported_inertia: {text} kg m^2\n{log}"})[
            "students"
        ].values()
        assert one["slips"] == []
        assert points(one)["own_data"] == 0
        assert any("no common mistake explains it" in look for look in one["look"])


@pytest.mark.slow
@pytest.mark.parametrize("balance", BALANCES[1:])
def test_statement_about_the_balance_makes_no_wrong_answer_right(balance: str) -> None:
    files = {
        "plain/lab.csv": f"{OFF}\n{STUDENT.log()}",
        "stated/lab.csv": f"{balance}{OFF}\n{STUDENT.log()}",
    }
    plain, stated = grade(files, "--lms", "folder")["students"].values()
    assert stated["points"] <= plain["points"]
    assert any("no common mistake explains it" in look for look in stated["look"])


@pytest.mark.slow
def test_zero_has_no_digits() -> None:
    for student in answered("0.00 ± 0.01", "0 ± 0.001", "0.0"):
        assert (points(student)["units"], points(student)["own_data"]) == (0, 0)


def test_rounded_answers_keep_all_points() -> None:
    (student,) = answered(f"{1e3 * OWN:.1f}e-3 ± 0.1e-3")
    assert points(student)["own_data"] == 6


@pytest.mark.slow
def test_mistake_without_a_name_costs_points_once() -> None:
    """The log is right, so that only the arithmetic costs points; a person is asked."""
    for student in answered(
        *(f"{factor * OWN:.6f} ± 0.00006" for factor in (0.83, 0.9, 1.1, 1.3))
    ):
        found = points(student)
        assert (found["own_data"], found["reference"]) == (0, 3)
        assert any("no common mistake explains it" in look for look in student["look"])


@pytest.mark.slow
def test_answers_at_random_get_no_points_without_a_question() -> None:
    random, texts = np.random.default_rng(8), []
    for value in 10 ** random.uniform(-6, 2, 30):
        power = int(np.floor(np.log10(value)))
        texts.append(
            f"{value / 10.0**power:.2f}e{power} ± {0.0135 * value / 10.0**power:.2f}e{power}"
        )
    graded = zip(texts, answered(*texts), strict=True)
    silent = [text for text, one in graded if one["points"] >= 16 and not one["look"]]
    # An answer that is nearly right by chance is no mistake.
    assert (
        len([text for text in silent if abs(float(text.split()[0]) / OWN - 1) > 0.1])
        <= 1
    )


@pytest.mark.slow
@pytest.mark.parametrize("fit", FITS)
def test_common_mistake_in_exact_arithmetic_is_no_question(fit: str) -> None:
    value, u = STUDENT.answer(fit=fit)
    line = reported_line(100 * value, 100 * u)[
        len("# reported_inertia: ") : -len(" kg m^2")
    ]
    exact, near = answered(line, f"{99 * value:.4f} ± {100 * u:.4f}")
    assert [one["slips"][0]["kind"] for one in (exact, near)] == ["cm_as_m"] * 2
    assert exact["look"] == []
    assert near["look"] != []
    # Another g, and an uncertainty with the one of the ruler.
    (other,) = answered(f"{100 * value * 9.8 / 9.80665:.4f} ± {250 * u:.4f}")
    assert other["look"] == []


@pytest.mark.parametrize("kind", ["md", "html", "txt"])
def test_property_of_word_in_another_text_is_no_fault(kind: str) -> None:
    """A property may stand outside of a piece of text."""
    for part in ("<w:strike/>", "<w:color w:val='ffffff'/>", "<p><w:vanish/></p>"):
        found = alone(f"report.{kind}", f"{part}\n\n{RIGHT}\n")
        assert (found["status"], found["look"]) == ("graded", [])
