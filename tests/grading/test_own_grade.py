"""A student cannot raise the own grade: not by unseen text, a second answer, statements, or somebody else's log."""

import io
import json
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import openpyxl
import pytest
from classes.cells import grade
from classes.drawn import USUAL, draw
from msgspec.structs import replace

STUDENT = draw(3, 21, replace(USUAL, hand=0.08))
WRONG = "I_zz = 5.20e-3 ± 0.06e-3 kg m^2"
RIGHT = f"Final result: I_zz = {STUDENT.answer()[0]:.6f} ± 0.00006 kg m^2"
FLAT = '<office:document-content xmlns:office="o" xmlns:text="t" xmlns:style="s" xmlns:fo="f">{}</office:document-content>'


def alone(report: str, content: str | bytes, log: str = STUDENT.log()) -> dict[str, Any]:
    """Grade one student who hands in a log and a report."""
    files: Mapping[str, str | bytes] = {"ann/lab.csv": log, f"ann/{report}": content}
    return dict(grade(files, "--lms", "folder")["students"]["ann"])


def packed(**parts: str) -> bytes:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, text in parts.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return data.getvalue()


def word(properties: str, style: str = "", around: str = "{}") -> bytes:
    run = f"<w:r><w:rPr>{properties}</w:rPr><w:t>{RIGHT}</w:t></w:r>"
    body = f"<w:p><w:r><w:t>{WRONG}</w:t></w:r></w:p>{around.format(f'<w:p>{run}</w:p>')}"
    document = f'<?xml version="1.0"?><w:document xmlns:w="w"><w:body>{body}</w:body></w:document>'
    return packed(word__document_xml=document, word__styles_xml=f'<w:styles xmlns:w="w">{style}</w:styles>')


def open_text(properties: str, element: str = "text:span") -> bytes:
    style = f'<style:style style:name="T1"><style:text-properties {properties}/></style:style>'
    hidden = f'<{element} text:style-name="T1">{RIGHT}</{element}>'
    return packed(content_xml=FLAT.format(f"{style}<text:p>{WRONG}</text:p><text:p>{hidden}</text:p>"))


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
    return json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})


def page(hidden: str, head: str = "") -> str:
    return f"<html><head>{head}</head><body><p>{WRONG}</p>{hidden}<p>The end.</p></body></html>"


STYLES = (
    "display:none", "DISPLAY: None !important", "visibility:hidden", "visibility:collapse", "opacity:0",
    "font-size:0", "font-size: 0.5px", "color:white", "color:#fff", "color:#FEFEFE", "color: rgb(255, 255, 255)",
    "color:transparent", "color:rgba(0,0,0,0)", "color:#123456;background:#123456", "text-indent:-9999px",
    "position:absolute;left:-5000px", "height:0;overflow:hidden", "color:hsl(0,0%,100%)",
)  # fmt: skip
SHEETS = (".no { display: none }", "body span { visibility: hidden }", "#no, b { color: white }", "span.no{font-size:0}")
PAGES = {
    **{style: page(f'<span style="{style}">{RIGHT}</span>') for style in STYLES},
    **{sheet: page(f'<span class="no" id="no">{RIGHT}</span>', f"<style>{sheet}</style>") for sheet in SHEETS},
    **{name: page(f"<{name}>{RIGHT}</{name}>") for name in ("template", "script", "style", "noscript", "dialog")},
    "title": page("", f"<title>{RIGHT}</title>"),
    "hidden": page(f"<div hidden><div><b>{RIGHT}</b></div></div>"),
    "font": page(f'<font color="#ffffff">{RIGHT}</font>'),
    "attribute": page(f'<a title="> {RIGHT}">here</a>'),
    "comment": page(f"<!-- {'x' * 3000} {RIGHT} -->"),
    "open comment": page(f"<!-- {RIGHT}"),
}
LATEX = {
    **{name: f"{WRONG}\n\n\\{name}{{{RIGHT}}}\n" for name in ("phantom", "hphantom", "vphantom", "textcolor{white}")},
    "color": f"{WRONG}\n\n{{\\color{{white}} {{\\bf {RIGHT}}}}}\n",
    "rgb": f"{WRONG}\n\n\\textcolor[rgb]{{1,1,1}}{{{RIGHT}}}\n",
    "end": f"\\begin{{document}}\n{WRONG}\n\\end{{document}}\n{RIGHT}\n",
}
MARKDOWN = {
    "link": f"{WRONG}\n\n[//]: # ({RIGHT})\n",
    "quotes": f'{WRONG}\n\n[note]: <> "{RIGHT}"\n',
    "element": f'{WRONG}\n\n<span style="display:none">{RIGHT}</span>\n',
    "comment": f"{WRONG}\n\n<!-- {'x' * 3000} {RIGHT} -->\n",
}
WORDS = {
    **{tag: word(f"<w:{tag}/>") for tag in ("vanish", "specVanish", "strike")},
    "white": word('<w:color w:val="FFFFFF"/>'),
    "theme": word('<w:color w:val="auto" w:themeColor="background1"/>'),
    "small": word('<w:sz w:val="2"/>'),
    "style": word('<w:rStyle w:val="No"/>', '<w:style w:styleId="No"><w:rPr><w:vanish/></w:rPr></w:style>'),
    "deleted": word("", around="<w:del>{}</w:del>"),
}
OPEN = ('text:display="none"', 'fo:color="#ffffff"', 'fo:font-size="0pt"')
UNSEEN: dict[str, tuple[str, str | bytes]] = {
    **{f"html, {name}": ("report.html", text) for name, text in PAGES.items()},
    **{f"tex, {name}": ("report.tex", text) for name, text in LATEX.items()},
    **{f"md, {name}": ("report.md", text) for name, text in MARKDOWN.items()},
    **{f"docx, {name}": ("report.docx", text) for name, text in WORDS.items()},
    **{f"odt, {one}": ("report.odt", open_text(one)) for one in OPEN},
    "odt, tracked": ("report.odt", open_text("", "text:tracked-changes")),
    **{f"xlsx, {state}": ("report.xlsx", workbook(state)) for state in ("hidden", "veryHidden")},
    "ipynb, raw": ("report.ipynb", notebook("raw", RIGHT)),
    "ipynb, source": ("report.ipynb", notebook("code", f"# {RIGHT}", jupyter={"source_hidden": True})),
    "ipynb, element": ("report.ipynb", notebook("markdown", f"<i hidden>{RIGHT}</i>")),
    "txt, blanks": ("report.txt", f"{WRONG}\n{' ' * 900}{RIGHT}\n"),
    "txt, behind": ("report.txt", f"{WRONG}{' ' * 900}{RIGHT}\n"),
    "md, blanks": ("report.md", f"{WRONG}\n\n{' ' * 900}{RIGHT}\n"),
}


@pytest.fixture(scope="module")
def honest_points() -> float:
    """Points of a wrong answer."""
    return float(alone("report.txt", WRONG)["points"])


@pytest.mark.parametrize("way", UNSEEN)
def test_unseen_text_is_no_answer(way: str, honest_points: float) -> None:
    student = alone(*UNSEEN[way])
    assert (student["reported"]["value"], student["points"]) == (pytest.approx(5.2e-3), honest_points)
    assert not any("two answers" in look for look in student["look"])
    # Without another answer, there is none.
    name, content = UNSEEN[way]
    if isinstance(content, str):
        assert alone(name, content.replace(WRONG, "Our report."))["status"] == "not graded"


SEEN = {
    "white on black": ("report.html", page(f'<p style="background:#111"><b style="color:white">{RIGHT}</b></p>')),
    "white on a picture": ("report.html", page(f'<p style="background:url(a.png);color:#fff">{RIGHT}</p>')),
    "style for printers": ("report.html", page(RIGHT, "<style>@media print { p, body { display: none } }</style>")),
    "other class": ("report.html", page(f"<p class='b'>{RIGHT}</p>", "<style>p.a { display: none }</style>")),
    "hidden before": ("report.html", page(f"<p hidden>no<p>{RIGHT}</p>")),
    "visible again": (
        "report.html",
        page(f'<div style="visibility:hidden">no<b style="visibility:visible">{RIGHT}</b></div>'),
    ),
    "word, white on a shade": ("report.docx", word('<w:color w:val="FFFFFF"/><w:shd w:fill="000000"/>')),
    "word, vanish off": ("report.docx", word('<w:vanish w:val="0"/>')),
    "black": ("report.tex", f"\\textcolor{{blue}}{{{RIGHT}}}\n"),
    "link that is none": ("report.md", f"[note]: {RIGHT}\n"),
    "visible sheet": ("report.xlsx", workbook("visible")),
}


@pytest.mark.parametrize("way", SEEN)
def test_text_that_a_person_sees_is_read(way: str) -> None:
    name, content = SEEN[way]
    content = content.replace(WRONG, "Our report.") if isinstance(content, str) else content
    assert alone(name, content)["reported"]["text"] in RIGHT


TWICE: dict[str, Callable[[], dict[str, Any]]] = {
    "text": lambda: alone("report.txt", f"{WRONG}\n{RIGHT}\n"),
    "html": lambda: alone("report.html", page(f"<p>{RIGHT}</p>")),
    "two files": lambda: grade_with({"ann/a.txt": WRONG, "ann/b.md": RIGHT}, STUDENT.log()),
    "log and text": lambda: alone("report.txt", WRONG, STUDENT.log(f"# reported_inertia: {RIGHT.split('= ')[1]}")),
    "two lines": lambda: alone("a.png", "", STUDENT.log(f"# {WRONG}", f"# reported_inertia: {RIGHT.split('= ')[1]}")),
    "below": lambda: alone("a.png", "", STUDENT.log(f"# reported_inertia: {RIGHT.split('= ')[1]}", foot=f"# {WRONG}\n")),
    "final": lambda: grade_with({"ann/report.txt": WRONG, "ann/final_v99.txt": RIGHT}, STUDENT.log()),
}


def grade_with(files: Mapping[str, str], log: str) -> dict[str, Any]:
    return dict(grade({"ann/lab.csv": log, **files}, "--lms", "folder")["students"]["ann"])


@pytest.mark.parametrize("place", TWICE)
def test_two_answers_that_differ_are_a_question(place: str) -> None:
    (look,) = (look for look in TWICE[place]()["look"] if look.startswith("two answers"))
    assert "5.20e-3" in look


def test_answers_that_agree_are_no_question() -> None:
    value = STUDENT.answer()[0]
    near = f"mean: I_zz = {1.01 * value:.6f} ± 0.00006 kg m^2\n{RIGHT}\n"
    assert alone("report.txt", near)["look"] == []
