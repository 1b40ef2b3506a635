"""Markdown, LaTeX and CSV: what they say, and that no text of a log does anything in
them.
"""

from __future__ import annotations

import csv
import html
import io
import re
import shutil
import subprocess
import unicodedata
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from analyzed_once import analyzed_once, drawn_once
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from pages import IN_ORDER, KINDS, Structure, analysis_of, known, make_page
from PIL import Image
from places import SAMPLES
from typer.testing import CliRunner, Result

from gyrodata import analyze
from gyrodata.cli import app
from gyrodata.reporting.data import table_header, table_rows
from gyrodata.reporting.figures import FIGURES
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.reporting.page import report_page
from gyrodata.reporting.text import summary
from gyrodata.results import Analysis

SAMPLE = SAMPLES / "air_gyroscope.csv"
HEAD = (
    "# g: 9.803 m/s^2\n# station: \\input{x} $3$ & 50 % | <b>\n"
    "run,mass [g],position [cm],spin [rpm],time [s],turns,note\n"
)
EVIL = (
    r"\input{/etc/passwd} \end{document} \write18{ls}",
    "100 % & #1 _x_ ~ ^ $y$ {z} [w] \\\\ `` '' -- ,, << >> ?` !`",
    "<script>alert(1)</script> | a | b ``` <!-- &amp; ![x](http://x.y/z.png) :smile: @all",
    "=cmd|' /C calc'!A0;=1+1",
    "Пётр Ильич, Її й ґ ў; Łódź, façade, ångström, ß; φ̇ψ̇ ά Ω; 中文 😀 ½ ＝1",
    "line one\nline two\ttab",
)


@cache
def evil() -> Analysis:
    """An analysis of a log with a text that does harm somewhere in every place that
    takes one.
    """
    out = io.StringIO()
    writer = csv.writer(out)
    for i, note in enumerate(EVIL):
        rpm = 200 + 60 * i
        writer.writerow(
            [f"[{i}]*" if i else "-1", 20, 15, rpm, round(rpm * 0.0993, 2), 1, note]
        )
    writer.writerow(["odd", 20, 15, 300, 61.0, 1, "=1"])
    return analyze((HEAD + out.getvalue()).encode(), name="Лаба_4 100% \\x|<i>.csv")


def with_texts(text: str) -> Analysis:
    """The same runs, with one text in the log's name and in every note."""
    return replace(
        evil(),
        name=text,
        readings=replace(evil().readings, notes=(text,) * len(evil().run_table)),
    )


def gyro(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)], env={"TERM": "dumb"})


TEXTS = st.text(max_size=40) | st.text(
    "\\{}[]()<>|*_`~#$%&^-+=@!;:,.'\"\n\t 1aé", max_size=40
)


# --- what is read ---


@pytest.mark.slow
@drawn_once()
def test_a_document_is_written_beside_figures_that_it_can_show(tmp_path: Path) -> None:
    log = SAMPLES / "salort_one_torque.csv"
    for form, figures, document, shown in (
        ("latex", "svg", "tex", "pdf"),
        ("markdown", "pdf", "md", "svg"),
    ):
        folder = tmp_path / form
        done = gyro("analyze", log, "-f", form, "--figures", figures, "-o", folder)
        assert f"report: {folder / 'report'}.{document}" in done.stderr
        assert (folder / f"report.{document}").read_text(
            encoding="utf-8"
        ) == done.stdout
        drawn = {path.name for path in folder.iterdir()}
        assert {
            f"{name}.{end}" for name in FIGURES for end in (shown, figures)
        } <= drawn


@pytest.mark.slow
def test_the_commands_that_a_report_names_answer() -> None:
    path = SAMPLES / "salort_one_torque.csv"
    report = markdown_report(analyze(path))
    commands = re.findall("`gyro ((?:predict|explain) [^`]*)`", report)
    assert [command.split()[1] for command in commands] == [
        "tip",
        "precession",
        "twist",
        "earth",
        "platform",
        "statistics",
        "theory",
    ]
    for command in commands:
        done = gyro(
            *(str(path) if word == path.name else word for word in command.split())
        )
        assert done.exit_code == 0, command
        assert len(done.stdout) > 300


@pytest.mark.slow
def test_a_report_that_is_handed_in_has_one_answer(tmp_path: Path) -> None:
    shutil.copy(SAMPLES / "air_gyroscope.csv", tmp_path / "lab.csv")
    report = gyro("analyze", tmp_path / "lab.csv", "-f", "markdown").stdout
    (tmp_path / "report.md").write_text(report, encoding="utf-8")
    told = gyro("check", "--hand-in", tmp_path).stdout
    assert "G719: only a report of gyro analyze contains an answer" in told
    assert "I_zz = (4.416 ± 0.033) × 10⁻³ kg·m², read from report.md, line 7" in told


NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)*(?:e[-+]\d+)?(?:/\d+)?")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_each_number_of_a_document_is_on_the_page_in_order(kind: str) -> None:
    """On the page each of them is compared with its place in results.json."""
    analysis = analysis_of(kind)
    # A note may contain any number.
    analysis = replace(
        analysis,
        readings=replace(analysis.readings, notes=("",) * len(analysis.run_table)),
    )
    told = known(analysis)
    text = re.sub(r"\\(.)", r"\1", markdown_report(analysis))
    # The words for a figure repeat numbers.
    text = re.sub(r"!\[.*", "", text)
    text = re.sub(r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|M0|\s+", " ", text.replace("−", "-"))
    for words in told:
        plain = re.escape(re.sub(r"M0|\s+", " ", words.replace("−", "-")))
        text = re.sub(rf"(?<![\d.]){plain}(?!\d|\.\d)", " ", text)
    shown = [
        number.replace("−", "-")
        for _, number in Structure(make_page(analysis)).numbers
        if number not in told
    ]
    assert NUMBER.findall(text) == NUMBER.findall(" ".join(shown))


# --- LaTeX ---


@pytest.mark.slow
def test_signs_are_formulas_and_letters_stay_as_they_are_in_latex() -> None:
    written = {
        "Łódź façade, Пётр 中": "Łódź façade, Пётр 中",
        "φ̇ψ̇ ± 5 µ": r"$\dot\varphi\dot\psi \pm$ 5 µ",
        "I_zz, M0·10⁻³ 5 %": r"$I_{zz}$, $M_0\cdot10^{-3}$ 5~\%",
        r"\input{x} a_b --log": (
            r"\textbackslash{}input\{x\} a\_\allowbreak{}b -{}-log"
        ),
        "\u202e\u200b": "",
    }
    report = latex_report(replace(evil(), name=f"qqq {' qqq '.join(written)} qqq"))
    shown = [text.strip() for text in report.split("qqq")[1 : len(written) + 1]]
    assert dict(zip(written, shown, strict=True)) == written


def test_a_letter_in_a_text_of_the_student_is_no_symbol() -> None:
    """Only letters in the words of the tool are set as mathematics."""
    head = "# author: team b\n# station: n\nday,run,mass [g],position [cm],spin [rpm],"
    log = head + "time [s],turns,M,note\n"
    for i, rpm in enumerate((200, 300, 400, 500, 600, 250)):
        day, mass = ("p", 20) if i % 2 else ("k", 40)
        period = round(1.986 * rpm / mass, 2)
        log += f"{day},{'bknpuL'[i]},{mass},15,{rpm},{period},1,3,p was M\n"
    analysis = analyze(log.encode(), name="lab b/team u.csv")
    document = latex_report(analysis)
    page = report_page(analysis, {})
    for text in ("team b", "lab b/team u.csv", "p was M", "Station: n", '"M"'):
        assert text in document
        assert html.escape(text).replace("&quot;", "&#34;") in page
    # The tool's own letters: these are symbols.
    for letter in "bknpuLM":
        named = re.findall(
            rf"(?:team|lab|run|Station:|was|note:) \${letter}\$", document
        )
        assert named == []
    assert "$u$" in document
    assert "<i>u</i>" in page


@pytest.mark.slow
@given(TEXTS)
@settings(derandomize=True, deadline=None, max_examples=15)
def test_the_document_is_sound_whatever_the_log_says(text: str) -> None:
    document = latex_report(with_texts(text))
    bare = re.sub(r"\\.", "", document)
    assert bare.count("{") == bare.count("}")
    kinds = re.findall(r"\\(begin|end)\{(\w+)\}", document)
    assert Counter(name for kind, name in kinds if kind == "begin") == Counter(
        name for kind, name in kinds if kind == "end"
    )


@pytest.mark.parametrize(
    ("engine", "analysis"), [("lualatex", evil), ("pdflatex", lambda: analyze(SAMPLE))]
)
def test_the_document_compiles_when_latex_is_installed(
    engine: str, analysis: Callable[[], Analysis], tmp_path: Path
) -> None:
    finder = shutil.which("kpsewhich")
    needed = ["siunitx.sty", *["luaotfload-main.lua"] * (engine == "lualatex")]
    if (
        shutil.which(engine) is None
        or finder is None
        or any(subprocess.run([finder, name]).returncode for name in needed)
    ):
        pytest.skip(f"no {engine} with siunitx on this machine")
    (tmp_path / "report.tex").write_text(latex_report(analysis()), encoding="utf-8")
    for name in FIGURES:
        Image.new("RGB", (66, 42), "white").save(tmp_path / f"{name}.png")
    command = [
        engine,
        "-interaction=nonstopmode",
        "-halt-on-error",
        "-recorder",
        "report.tex",
    ]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:].decode("utf-8", "replace")
    assert "passwd" not in (tmp_path / "report.fls").read_text("utf-8", "replace")


# --- Markdown ---


def shown_as(source: str) -> str:
    """HTML that a reader of tables and raw HTML makes of Markdown."""
    library = pytest.importorskip(
        "markdown_it", reason="markdown-it-py is not installed"
    )
    rendered: str = (
        library.MarkdownIt("commonmark")
        .enable("table")
        .enable("strikethrough")
        .render(source)
    )
    return rendered


OTHER_TAG = re.compile(
    r"<(?!/?(?:h[1-3]|p|em|strong|code|img|ul|li|table|thead|tbody|t[rhd])\b)"
)


@pytest.mark.slow
@given(TEXTS)
@settings(derandomize=True, deadline=None, max_examples=12)
def test_text_stays_text_in_markdown(text: str) -> None:
    assert not OTHER_TAG.search(shown_as(markdown_report(with_texts(text))))


def test_a_hostile_log_is_a_harmless_page() -> None:
    page = shown_as(markdown_report(evil()))
    assert "<script" not in page
    assert "<i>" not in page
    assert re.findall(r'<img src="([^"]*)', page) == [
        f"{name}.png" for name in IN_ORDER
    ]
    assert not [
        code
        for code in re.findall("<code>(.*?)</code>", page)
        if "cmd" in code or "alert" in code
    ]
    assert html.escape(EVIL[2]) in page


# --- CSV ---


@pytest.mark.slow
@given(TEXTS)
@settings(derandomize=True, deadline=None, max_examples=100)
def test_no_cell_is_a_formula_and_negative_numbers_stay_numbers(text: str) -> None:
    analysis = with_texts(text)
    table = table_header("runs") + table_rows(analysis, "runs")
    head, *rows = csv.reader(io.StringIO(table, newline=""))
    assert [len(row) for row in rows] == [len(head)] * len(analysis.run_table)
    # Where ; or a tab parts cells, quotes in the middle of a cell mean nothing.
    split = [cell for line in table.splitlines() for cell in re.split(r"[;\t]", line)]
    for cell in [cell for row in rows for cell in row] + split:
        number = re.fullmatch(r"[-+]?[\d.]+(e[-+]\d+)?", cell)
        assert number or not re.match(r"[\s\"]*[=+\-@＝＋－＠]", cell), cell
    residuals = [float(row[head.index("residual [s]")]) for row in rows]
    assert residuals == [float(f"{run.residual:.12g}") for run in analysis.run_table]


# --- text ---


@pytest.mark.slow
@given(st.text(max_size=20) | st.text("\x1b[]0;m\x07\x9b\r\b", max_size=20))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_no_text_commands_a_terminal(text: str) -> None:
    analysis = with_texts(text)
    runs = tuple(
        replace(run, run=text, reason=text, flagged=True) for run in analysis.run_table
    )
    shown = summary(replace(analysis, run_table=runs))
    assert not [c for c in shown if unicodedata.category(c) == "Cc" and c != "\n"]


# --- digits ---

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def significant(number: str) -> int:
    """Count the significant digits of a number."""
    return len(re.split("[eE]", number)[0].replace(".", "").strip("-0"))


def numbers_in(text: str) -> list[str]:
    """Find the numbers of a text in JSON or CSV, but not those in its strings."""
    if text.startswith("{"):
        return NUMBER.findall(re.sub(r'"(?:[^"\\]|\\.)*"', '""', text))
    cells = (cell for row in csv.reader(io.StringIO(text)) for cell in row)
    return [cell for cell in cells if NUMBER.fullmatch(cell)]


@pytest.mark.slow
def test_numbers_for_programs_have_12_digits(tmp_path: Path) -> None:
    (tmp_path / "class" / "ann").mkdir(parents=True)
    log = b"# reported_inertia: 4.44e-3 kg m^2\n" + SAMPLE.read_bytes()
    (tmp_path / "class" / "ann" / "log.csv").write_bytes(log)
    report = tmp_path / "report"
    commands = [
        ["analyze", str(SAMPLE), "--format", "json", "--out", str(report)],
        [
            "analyze",
            str(SAMPLE),
            str(SAMPLES / "heidelberg_ball.csv"),
            "--format",
            "ndjson",
            "--no-report",
        ],
        ["analyze", str(SAMPLE), "--format", "csv", "--no-report"],
        ["analyze", str(SAMPLE), "--format", "csv", "--table", "logs", "--no-report"],
        ["check", str(SAMPLE), "--format", "json"],
        ["predict", "tip", "--log", str(SAMPLE), "--format", "json"],
        ["selfcheck", str(SAMPLE), "--labs", "5", "--format", "json"],
        ["grade", str(tmp_path / "class"), "--format", "json", "--workers", "0"],
        ["grade", str(tmp_path / "class"), "--format", "ndjson", "--workers", "0"],
    ]
    texts = []
    with analyzed_once():
        for command in commands:
            done = CliRunner().invoke(app, command)
            assert done.exit_code in (0, 1), (command, done.output)
            texts.append(done.stdout)
    texts.append((report / "results.json").read_text(encoding="utf-8"))
    for command, text in zip([*commands, ["results.json"]], texts, strict=True):
        most = max(map(significant, numbers_in(text)), default=0)
        assert most <= 12, command
        assert most == 12 or command[0] in ("check", "grade"), command


@pytest.mark.slow
def test_objects_have_all_digits_and_their_json_is_rounded() -> None:
    lab = analyze(SAMPLE)
    told = lab.to_dict()["result"]
    values = [
        lab.inertia.value,
        lab.inertia.u,
        *lab.inertia.interval_95,
        *(run.residual for run in lab.run_table),
    ]
    shown = [
        told["inertia"]["value"],
        told["inertia"]["u"],
        *told["inertia"]["interval_95"],
    ]
    shown += [run["residual"] for run in told["runs"]]
    assert shown == [float(f"{value:.12g}") for value in values]
    assert max(significant(repr(value)) for value in values) > 12
