"""Reports in PDF: what a person sees is read, and nothing else."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from classes.class_cells import grade
from grading.students_reports import RIGHT, reported_line, sheet
from matplotlib.figure import Figure

ROWS = sheet(np.random.default_rng(1), "mixed")
LOG = ROWS.log()
VALUE, U = RIGHT.inertia(ROWS, "with_constant")
ANSWER = reported_line(VALUE, U).removeprefix("# reported_inertia: ")
WRONG = "I_zz = 9.99e-3 ± 0.05e-3 kg m^2"


def printed(*rows: str | Sequence[str], unseen: str = "", **style: Any) -> bytes:
    """Print rows of texts or cells into a PDF, and another text in another style."""
    figure = Figure()
    for number, row in enumerate(rows):
        for at, cell in enumerate([row] if isinstance(row, str) else row):
            figure.text(0.05 + 0.19 * at, 0.95 - 0.05 * number, cell)
    if unseen:
        figure.text(*style.pop("at", (0.05, 0.3)), unseen, **style)
    out = io.BytesIO()
    figure.savefig(out, format="pdf")
    return out.getvalue()


def typeset(*parts: str) -> bytes:
    """Show parts of a line; each second part is raised by an operator of the text."""
    from pypdf import PdfWriter
    from pypdf.generic import (
        ContentStream,
        DictionaryObject,
        NameObject,
    )

    shown = [
        f"{5 * (at % 2)} Ts /F {10 - 2 * (at % 2)} Tf ({part}) Tj"
        for at, part in enumerate(parts)
    ]
    writer = PdfWriter()
    page = writer.add_blank_page(600, 800)
    content = ContentStream(None, writer)
    content.set_data(f"BT 1 0 0 1 70 700 Tm {' '.join(shown)} ET".encode("cp1252"))
    keys = ("Type", "Font"), ("Subtype", "Type1"), ("BaseFont", "Helvetica")
    keys = (*keys, ("Encoding", "WinAnsiEncoding"))
    font = {NameObject(f"/{key}"): NameObject(f"/{value}") for key, value in keys}
    fonts = DictionaryObject({NameObject("/F"): DictionaryObject(font)})
    page[NameObject("/Resources")] = DictionaryObject({NameObject("/Font"): fonts})
    page[NameObject("/Contents")] = content
    out = io.BytesIO()
    writer.write(out)
    return out.getvalue()


def scanned() -> bytes:
    """Print a picture without a text."""
    figure = Figure()
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.imshow([[0, 1], [1, 0]])
    out = io.BytesIO()
    figure.savefig(out, format="pdf")
    return out.getvalue()


def handed_in(report: bytes, log: str = LOG) -> dict[str, Any]:
    files: dict[str, str | bytes] = {"ann/report.pdf": report}
    if log:
        files["ann/lab.csv"] = log
    return dict(grade(files, "--lms", "folder")["students"]["ann"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        ["Lab report", f"Final result: I_zz = {ANSWER}"],
        [["quantity", "value"], ["I_zz", ANSWER.replace(" kg m^2", ""), "kg m^2"]],
        ["We find the moment of inertia", f"I_zz = {ANSWER}."],
    ],
    ids=["line", "table", "prose"],
)
def test_answer_in_a_pdf_is_read(rows: list[Any]) -> None:
    student = handed_in(printed(*rows))
    assert (student["status"], student["look"]) == ("graded", [])
    assert student["reported"]["value"] == pytest.approx(VALUE, rel=1e-3)


IN_KG_CM2 = f"I_zz = {1e4 * VALUE:.2f} ± {1e4 * U:.2f} "
IN_10_3 = f"({1e3 * VALUE:.3f} ± {1e3 * U:.3f})"


@pytest.mark.slow
@pytest.mark.parametrize(
    "report",
    [
        typeset(f"{IN_KG_CM2} kg cm", "2", ", from a line."),
        typeset(f"I_zz = {IN_10_3} × 10", "-3", " kg m", "2", "."),
        typeset(f"I_zz = {1e3 * VALUE:.3f} × 10", "-3", " kg m", "2", " ± 0.9 %"),
        printed("Report", f"{IN_KG_CM2} $\\mathrm{{kg\\,cm^2}}$ (three weights)"),
        printed(
            "Report", f"I_zz = {IN_10_3} $\\times 10^{{-3}}\\ \\mathrm{{kg\\,m^2}}$"
        ),
    ],
    ids=["unit", "power", "share", "drawn unit", "drawn power"],
)
def test_superscript_in_a_pdf_is_read(report: bytes) -> None:
    student = handed_in(report)
    assert (student["status"], student["look"]) == ("graded", [])
    assert student["reported"]["value"] == pytest.approx(VALUE, rel=1e-3)
    assert student["reported"]["u"] == pytest.approx(0.009 * VALUE, rel=0.9)


@pytest.mark.slow
def test_number_of_a_footnote_in_a_pdf_is_no_digit() -> None:
    report = typeset(f"I_zz = {VALUE:.2e} ± {U:.1e}", "1", " kg m", "2")
    read = handed_in(report)["reported"]
    assert read.get("u") in (None, pytest.approx(U, rel=0.1))


@pytest.mark.slow
def test_unit_without_its_power_in_a_pdf_is_a_question() -> None:
    student = handed_in(printed("Report", f"{IN_KG_CM2} kg cm"))
    assert any("superscript" in look for look in student["look"])


@pytest.mark.slow
def test_table_of_runs_in_a_pdf_is_a_log() -> None:
    rows = [line.split(",") for line in LOG.splitlines() if line[:1] != "#"]
    student = handed_in(printed("Our runs", *rows, f"I_zz = {ANSWER}"), log="")
    assert student["status"] == "graded"
    assert student["inertia"] == pytest.approx(VALUE, rel=0.02)


@pytest.mark.slow
def test_pdf_without_a_text_needs_a_person() -> None:
    student = handed_in(scanned())
    assert student["status"] == "not graded"
    assert "no text" in student["why"]
    assert "a person must look" in student["why"]
    answered = handed_in(scanned(), log=f"# reported_inertia: {ANSWER}\n{LOG}")
    assert (answered["status"], answered["look"]) == ("graded", [])
    assert not [one for one in answered["diagnostics"] if "pdf" in one["message"]]


@pytest.mark.slow
@pytest.mark.parametrize(
    "style",
    [
        {"color": "white"},
        {"color": (0.97, 0.98, 0.97)},
        {"fontsize": 0.5},
        {"alpha": 0.01},
        {"at": (1.2, 0.3)},
    ],
    ids=["white", "nearly white", "tiny", "transparent", "beside the page"],
)
def test_text_that_a_person_does_not_see_is_no_answer(style: dict[str, Any]) -> None:
    unseen = f"Final result: I_zz = {ANSWER}"
    plain = handed_in(printed(WRONG))
    hidden = handed_in(printed(WRONG, unseen=unseen, **style))
    assert hidden["reported"]["value"] == plain["reported"]["value"] == 9.99e-3
    assert hidden["points"] == plain["points"]
    assert any("text that nobody sees" in look for look in hidden["look"])
    seen = handed_in(printed(WRONG, unseen=unseen, color="grey"))
    assert seen["look"], "the same text, if it can be seen, is asked about"


@pytest.mark.slow
@pytest.mark.parametrize(
    "style", [{"color": "white"}, {"fontsize": 0.5}, {"alpha": 0.01}]
)
def test_only_answer_that_nobody_sees_has_no_effect_and_is_told(
    style: dict[str, Any],
) -> None:
    plain = handed_in(printed("Our report."))
    hidden = handed_in(printed("Our report.", unseen=f"I_zz = {ANSWER}", **style))
    assert hidden["reported"] == plain["reported"]
    assert hidden["points"] == plain["points"]
    new = [look for look in hidden["look"] if look not in plain["look"]]
    (question,) = new
    assert question.startswith("report.pdf contains text that nobody sees")


@pytest.mark.slow
def test_unseen_text_beside_an_answer_of_the_log_is_told() -> None:
    log = f"# reported_inertia: {ANSWER}\n{LOG}"
    report = printed("Our report.", unseen=WRONG, color="white")
    student = handed_in(report, log)
    assert student["points"] == handed_in(printed("Our report."), log)["points"]
    assert any("text that nobody sees" in look for look in student["look"])


@pytest.mark.slow
def test_text_behind_a_picture_is_not_read() -> None:
    """A scanner writes such a text, and nobody can see whether it is right."""
    from pypdf import PdfReader, PdfWriter
    from pypdf.generic import NumberObject

    page = PdfReader(io.BytesIO(printed(f"I_zz = {ANSWER}"))).pages[0]
    content = page.get_contents()
    assert content is not None
    content.operations = [([NumberObject(3)], b"Tr"), *content.operations]
    writer = PdfWriter()
    writer.add_page(page)
    writer.pages[0].replace_contents(content)
    out = io.BytesIO()
    writer.write(out)
    student = handed_in(out.getvalue())
    assert (student["status"], "no text" in student["why"]) == ("not graded", True)


@pytest.mark.slow
@pytest.mark.parametrize(
    "data",
    [
        b"%PDF-1.4\n",
        b"%PDF-1.7\n" + b"[" * 5000,
        printed(WRONG)[:600],
        b"\x89PNG\r\n\x1a\n",
        b"",
    ],
    ids=["empty", "brackets", "cut off", "picture", "nothing"],
)
def test_damaged_pdf_is_named_and_costs_nobody_else(data: bytes) -> None:
    files: dict[str, str | bytes] = {
        "ann/lab.csv": LOG,
        "ann/report.pdf": data,
        "bob/lab.csv": f"# reported_inertia: {ANSWER}\n{LOG}",
    }
    students = grade(files, "--lms", "folder")["students"]
    assert students["bob"]["status"] == "graded"
    assert students["ann"]["status"] == "not graded"
    assert "report.pdf" in students["ann"]["why"]
