"""An answer that may be unseen, or beside an unread part, is graded with a question."""

import io
import json
from collections.abc import Callable
from typing import Any

import openpyxl
import pytest
from classes.class_cells import grade
from grading.classes import packed as zipped
from grading.test_own_grade import (
    OWN,
    RIGHT,
    ROWS,
    STUDENT,
    TITLES,
    WRONG,
    packed,
    page,
    word,
)
from openpyxl.styles import Font

VALUE = RIGHT.split("= ")[1]
COMPARED = (f"As expected, {WRONG}", f"In comparison, {WRONG}")


def styled(rules: str, start: str = '<p class="note">') -> str:
    """Write a page whose only answer is in an element that a style sheet describes."""
    end = start.split()[0].replace("<", "</").rstrip(">") + ">"
    return page(f"{start}{RIGHT}{end}", f"<style>{rules}</style>").replace(
        WRONG, "Our report."
    )


PAGES = {
    "display": styled(".note { display: none }"),
    "two rules": styled("p { margin: 0 } div, p.note { DISPLAY : none !important }"),
    "id": styled("#last { visibility: hidden }", '<p id="last">'),
    "around": styled("div.a > p { font-size: 0 }", '<div class="a"><p>'),
    "white": styled("p.note { color: #fff }"),
    "all": styled("* { opacity: 0 }"),
    "clip": styled(".note { position: absolute; clip: rect(0 0 0 0) }"),
    "screens": styled("@media screen { .note { display: none } }"),
    "state": styled("p:not(.b) { display: none }"),
    "tiny": page(f'<span style="font-size:3px">{RIGHT}</span>').replace(WRONG, ""),
    "light": page(f'<span style="color:#f5f5f5">{RIGHT}</span>').replace(WRONG, ""),
    "scaled": page(f'<b style="transform:scale(0)">{RIGHT}</b>').replace(WRONG, ""),
    "elsewhere": styled(".menu { display: none }"),
    "written": page(f"<p>{RIGHT}</p>", f'<style>p::after{{content:"{WRONG}"}}</style>')
    .replace(f"<p>{WRONG}</p>", "")
    .replace("±", "+-"),
}


def notebook(tag: str) -> str:
    cell = {"cell_type": "code", "source": [f"# {RIGHT}"], "outputs": []}
    return json.dumps({"cells": [{**cell, "metadata": {"tags": [tag]}}]})


def styled_word(properties: str) -> bytes:
    """Write a Word file whose only answer has a style of its own."""
    style = f'<w:style w:styleId="S1"><w:rPr>{properties}</w:rPr></w:style>'
    styles = f'<w:styles xmlns:w="w">{style}</w:styles>'
    run = f'<w:r><w:rPr><w:rStyle w:val="S1"/></w:rPr><w:t>{RIGHT}</w:t></w:r>'
    document = f'<w:document xmlns:w="w"><w:body><w:p>{run}</w:p></w:body></w:document>'
    return packed(word__document_xml=document, word__styles_xml=styles)


def report_book(hide: Callable[[Any], None]) -> bytes:
    """Write a workbook with an answer, part of which is hidden."""
    book = openpyxl.Workbook()
    book.active.append(["Our report"])
    book.active.append(["Final result: I_zz =", VALUE])
    hide(book.active)
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def log_book(hide: Callable[[Any], None]) -> bytes:
    """Write a log as a workbook, with an answer that is hidden below the rows."""
    book = openpyxl.Workbook()
    book.active.append(TITLES.split(","))
    for row in ROWS:
        book.active.append([*map(float, row.split(",")[:4]), row.split(",")[4]])
    book.active.append([f"# reported_inertia: {VALUE}"])
    hide(book.active)
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def hide_row(sheet: Any) -> None:
    sheet.row_dimensions[sheet.max_row].hidden = True


def hide_column(sheet: Any) -> None:
    sheet.column_dimensions["B"].hidden = True


def blank(sheet: Any) -> None:
    for cell in sheet[sheet.max_row]:
        cell.number_format = ";;;"


def whiten(sheet: Any) -> None:
    for cell in sheet[sheet.max_row]:
        cell.font = Font(color="FFFFFFFF")


PROGRAMS = {
    "script": f"<p id=a>{RIGHT}</p><script>a.textContent = '{WRONG}'</script>",
    "handler": f"<p>{RIGHT}</p><img src=a onerror='document.body.remove()'>",
    "next page": f"<meta http-equiv=Refresh content='0; url=other.html'><p>{RIGHT}</p>",
}
"""Pages that a browser may show with another text."""
DOUBTED: dict[str, tuple[str, str | bytes]] = {
    **{f"html, {name}": ("report.html", text) for name, text in PROGRAMS.items()},
    **{f"html, {name}": ("report.html", text) for name, text in PAGES.items()},
    **{
        f"ipynb, {tag}": ("report.ipynb", notebook(tag))
        for tag in ("hide-input", "remove-cell", "hide_cell")
    },
    "docx, style hides": ("report.docx", styled_word("<w:vanish/>")),
    "docx, style is tiny": ("report.docx", styled_word('<w:sz w:val="2"/>')),
    "docx, narrow style": ("report.docx", styled_word('<w:w w:val="1"/>')),
    "docx, light": ("report.docx", word('<w:color w:val="F7F7F7"/>')),
    "md, above": ("report.md", f'---\ntitle: "{RIGHT}"\n---\n\nOur report.\n'),
    "tex, braces": ("report.tex", f"\\phantom{{{{}}{RIGHT}}}\n"),
    "tex, white": ("report.tex", f"Our report.\n\n\\color{{white}}\n{RIGHT}\n"),
    "tex, size": ("report.tex", f"{{\\fontsize{{1}}{{1}}\\selectfont {RIGHT}}}\n"),
    **{
        f"xlsx, {hide.__name__}": ("report.xlsx", report_book(hide))
        for hide in (hide_row, hide_column, blank, whiten)
    },
    **{
        f"log, {hide.__name__}": ("lab.xlsx", log_book(hide))
        for hide in (hide_row, blank, whiten)
    },
}
WIDTHS = {
    "name": ("I_zz", "I\u200b_z\u200bz"),
    "number": ("5.20", "5\u2060.2\u200d0"),
    "unit": ("kg", "k\u200bg"),
}
"""Where characters without a width are in the other answer."""
CUT = {
    "lines": f"{RIGHT}\n" + "A line of the report.\n" * 1100 + WRONG,
    "values": f"{RIGHT}\n" + f"{RIGHT}\n" * 110 + WRONG,
    "sentence": f"{RIGHT}\n{'and then we measured ' * 60} {WRONG}\n",
    "line": f"{RIGHT}\n{'Then we measured. ' * 1200} {WRONG}\n",
}


@pytest.fixture(scope="module")
def students() -> dict[str, Any]:
    """Everybody's grade."""
    reports = {
        **DOUBTED,
        **{f"cut, {name}": ("report.txt", text) for name, text in CUT.items()},
        **{text: ("report.txt", f"{text}.\n{RIGHT}\n") for text in COMPARED},
        **{
            f"width {place}": ("report.txt", f"{WRONG.replace(*parts)}\n{RIGHT}\n")
            for place, parts in WIDTHS.items()
        },
    }
    files: dict[str, str | bytes] = {}
    for name, (file, content) in reports.items():
        files[f"{name}/{file}"] = content
        if not file.startswith("lab"):
            files[f"{name}/lab.csv"] = STUDENT.log()
    return dict(grade(files, "--lms", "folder")["students"])


@pytest.mark.slow
@pytest.mark.parametrize("way", DOUBTED)
def test_answer_that_may_be_hidden_is_a_question(
    way: str, students: dict[str, Any]
) -> None:
    assert students[way]["reported"]["value"] == pytest.approx(OWN, rel=1e-3)
    looks = "; ".join(students[way]["look"])
    assert "may be hidden" in looks or "two answers" in looks


@pytest.mark.slow
@pytest.mark.parametrize("part", CUT)
def test_part_that_is_not_read_is_a_question(
    part: str, students: dict[str, Any]
) -> None:
    (look,) = students[f"cut, {part}"]["look"]
    assert look.startswith("report.txt is too long")


@pytest.mark.parametrize("text", [*COMPARED, *(f"width {place}" for place in WIDTHS)])
def test_other_answer_is_a_question_whatever_words_are_around_it(
    text: str, students: dict[str, Any]
) -> None:
    (look,) = students[text]["look"]
    assert look.startswith("two answers")


OPEN = {
    "theory": ("report.txt", f"{RIGHT}\nTheory: {WRONG}\n"),
    "solid ball": ("report.txt", f"{RIGHT}\n2/5 m r^2 of a solid ball = {WRONG}\n"),
    "group": ("report.txt", f"{RIGHT}\nThe other group got {WRONG}\n"),
    "compared": ("report.txt", f"{RIGHT}\nCompared with theory, {WRONG}\n"),
    "near": (
        "report.txt",
        f"{RIGHT}\nAs expected, I_zz = {1.01 * OWN:.6f} ± 0.00006 kg m^2\n",
    ),
    "long": ("report.txt", f"{RIGHT}\n" + "A line of the report.\n" * 1100),
    "printed": (
        "report.html",
        page(RIGHT, "<style>@media print{p,body{display:none}}</style>").replace(
            WRONG, ""
        ),
    ),
    "visible book": ("report.xlsx", report_book(lambda sheet: None)),
    "tags": ("report.ipynb", notebook("results")),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", OPEN)
def test_answer_that_is_seen_is_no_question(way: str) -> None:
    name, content = OPEN[way]
    files = {"ann/lab.csv": STUDENT.log(), f"ann/{name}": content}
    (student,) = grade(files, "--lms", "folder")["students"].values()
    assert student["reported"]["value"] == pytest.approx(OWN, rel=1e-3)
    assert student["look"] == []


BROKEN: dict[str, str | bytes] = {
    "deep.ipynb": '{"cells":' + "[" * 5000,
    "odd.ipynb": '{"cells":[5,null]}',
    "no.ipynb": "I_zz",
    "nul.txt": f"I_zz = {VALUE}\n\0",
    "cut.docx": zipped({"word/document.xml": RIGHT})[:60],
    "report.odt": zipped({"content.xml": RIGHT}),
    "empty.docx": zipped({"word/other.xml": RIGHT}),
    "book.xlsx": b"PK\3\4no workbook",
    "huge.ods": zipped(
        {
            "content.xml": '<o xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"'
            ' xmlns:text="urn:oasis:names:tc:opendocument:xmlns:text:1.0"><table:table>'
            '<table:table-row table:number-rows-repeated="1000000">'
            '<table:table-cell table:number-columns-repeated="16000"><text:p>4</text:p>'
            "</table:table-cell></table:table-row></table:table></o>"
        }
    ),
}


@pytest.mark.slow
def test_file_that_cannot_be_read_is_named_with_the_reason() -> None:
    files: dict[str, str | bytes] = {}
    for name, content in BROKEN.items():
        files |= {f"{name}/lab.csv": STUDENT.log(), f"{name}/{name}": content}
        files |= {
            f"{name} beside/lab.csv": STUDENT.log(),
            f"{name} beside/{name}": content,
            f"{name} beside/report.txt": RIGHT,
        }
    students = grade(files, "--lms", "folder")["students"]
    for name in BROKEN:
        alone, beside = students[name], students[f"{name} beside"]
        assert f'"{name}" cannot be read: ' in str(alone["why"])
        assert beside["status"] == "graded"
        for one in (alone, beside):
            told = [note for note in one["diagnostics"] if note["code"] == "G713"]
            assert [note["message"].split('"')[1] for note in told] == [name]
