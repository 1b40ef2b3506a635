"""The figures as a reader sees them: texts that can be read, a mark for each run, the
same bytes on every run.
"""

from __future__ import annotations

import html
import os
import re
import subprocess
import sys
import warnings
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path
from msgspec.structs import replace

from gyrodata import Analysis as Lab
from gyrodata import analyze
from gyrodata.reporting import figures
from gyrodata.reporting.elements import Numbers
from gyrodata.reporting.figure_data import Scene, list_groups
from gyrodata.reporting.figures import (
    ALL_FIGURES,
    FIGURES,
    STYLES,
    Kind,
    alternatives,
    plot_on,
    render,
)
from gyrodata.results import Analysis

HEADER = "run,mass [g],position [cm],spin [rpm],time [s],turns"


def log(
    masses: list[float],
    spins: list[float],
    position: float = 15.0,
    scale: float = 1.0,
    wrong: int = -1,
) -> bytes:
    """A log without noise but for a fixed ± 0.1 s; `scale` multiplies I_zz and the
    masses.
    """
    rows = ["# g: 9.803 m/s^2", HEADER]
    for number, (mass, spin) in enumerate((m, s) for m in masses for s in spins):
        torque = (
            1e-3 * mass * scale * 9.803 * 1e-2 * position
            + 0.0007 * scale * np.sign(position)
        )
        period = 2 * np.pi * 0.00444 * scale * spin * np.pi / 30 / abs(torque)
        turns, time = ("1", period) if period < 90 else ("1/3", period / 3)
        turns, place = "2" if number == wrong else turns, f"{position}" if mass else ""
        late = 0.1 * (-1) ** number
        rows.append(
            f'"{number + 1}",{mass * scale:.6g},{place},{spin},{time + late:.2f},{turns}'
        )
    return "\n".join(rows).encode() + b"\n"


LOGS = {
    "3 x 3": log([20, 40, 60], [200, 400, 600]),
    "with unloaded runs": log([20, 40, 60, 0], [200, 400, 600]),
    "one run": log([50], [400]),
    "thirty torques": log([10 + 4 * i for i in range(30)], [300]),
    "two odd runs": log([20, 40, 60], [200, 400, 600], wrong=4).replace(
        b'"8",60,15.0,400,13', b'"8",60,15.0,400,16'
    ),
    "weights that disagree": log([20, 40, 60], [200, 400, 600]).replace(
        b",40,15.0", b",46,15.0"
    ),
    "both senses": log([2, 4, 6], [200, 400, 600], position=900).replace(
        b"2,900,200,", b"2,-900,200,"
    ),
    "long numbers": log([20, 40, 60], [200, 400, 600], position=-15, scale=50),
    "tiny": log([20, 40, 60], [200, 400, 600], scale=1e-3),
}
TEXT = re.compile(r"<text ([^>]*)>(.*?)</text>")
UNITS = {
    "period": ["[rpm", "[s"],
    "product": ["[rpm", "[rad²/s²"],
    "torque": ["[rad²/s²", "N·m"],
    "residuals": ["u"],
}
"""Of the axes of some figures."""
OF_RUNS = [name for name, figure in FIGURES.items() if figure.draws_runs]


def drawn(analysis: Analysis, medium: str = "screen") -> dict[str, str]:
    return {
        name: data.decode()
        for name, data in render(analysis, ["svg"], medium)["svg"].items()
    }


@cache
def width_of(text: str, size: float) -> float:
    """Width of a text [point], by the advance of its letters."""
    font = FontProperties(size=size)
    width, *_ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
    return float(width)


def boxes(svg: str) -> list[tuple[str, float, float, float, float]]:
    """Each text of a figure with its left, top, right and bottom end [point]."""
    found = []
    for attributes, escaped in TEXT.findall(svg):
        text = html.unescape(escaped)
        [size] = re.findall(r"font-size: ([\d.]+)px", attributes)
        # A text without an anchor begins at its place.
        anchor = re.search(r"text-anchor: (\w+)", attributes)
        place = re.search(r"(?:translate|rotate)\((.*?)\)", attributes)
        assert place
        *turn, x, y = map(float, place[1].split())
        wide = width_of(text, float(size))
        share = {"start": 0.0, "middle": 0.5, "end": 1.0}
        start = share[anchor[1] if anchor else "start"] * wide
        high = 0.7 * float(size)
        box = x - start, y - high, x - start + wide, y
        if abs(sum(turn)) == 90:
            box = x - high, y + start - wide, x, y + start
        found.append((text, *box))
    return found


@cache
def analysis_of(name: str) -> Analysis:
    return analyze(LOGS[name], name="log.csv")


DRAWN = [
    *((name, "screen") for name in LOGS if name != "with unloaded runs"),
    *((name, "print") for name in ("with unloaded runs", "two odd runs")),
]
"""Nearly each log on a screen, and those with the longest texts on paper."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "medium"), DRAWN)
def test_texts_of_any_log_are_inside_and_apart(name: str, medium: str) -> None:
    for which, svg in drawn(analysis_of(name), medium).items():
        size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)
        assert size
        wide, tall = map(float, size.groups())
        texts = boxes(svg)
        said = " ".join(text for text, *_ in texts)
        assert ("Do not rely" in said) == bool(analysis_of(name).doubts)
        assert [unit for unit in UNITS.get(which, ()) if unit not in said] == [], said
        assert [
            text
            for text, *(a, b, c, d) in texts
            if min(a, b) < 0 or c > wide or d > tall
        ] == []
        for (one, *first), (other, *second) in combinations(texts, 2):
            across, up = (
                min(first[i + 2], second[i + 2]) - max(first[i], second[i])
                for i in (0, 1)
            )
            assert across <= 1.5 or up <= 1.5, (which, one, other)


def test_long_names_of_bars_are_not_cut_off(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["the reading of the stopwatch", "ruler", "mass of each weight"]

    def draw(ax: Axes, scene: Scene) -> None:
        ax.barh(names, [0.7, 0.2, 0.1])
        ax.set_xlabel("share of the variance")

    monkeypatch.setitem(ALL_FIGURES, "bars", Kind((draw,), "Shares."))
    drawn = render(analysis_of("3 x 3"), ["svg"], names=["bars"])["svg"]
    texts = boxes(drawn["bars"].decode())
    starts = {text: left for text, left, *_ in texts}
    assert min(starts[name] for name in names) > 0
    assert max(bottom for *_, bottom in texts) < 72 * STYLES["screen"].height


def test_a_figure_without_runs_has_no_words_about_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    of_bars = Kind((lambda ax, scene: None,), "Shares. Bars.", draws_runs=False)
    monkeypatch.setitem(ALL_FIGURES, "bars", of_bars)
    lab = analysis_of("two odd runs")
    monkeypatch.setattr(figures, "figures_of", lambda _: ("torque", "bars"))
    words = alternatives(lab)
    assert words["bars"].startswith("Shares. log.csv, ")
    assert ["hollow" in words[name] for name in ("torque", "bars")] == [True, False]


def test_help_of_plot_names_every_figure() -> None:
    assert [
        name for name in ALL_FIGURES if f'"{name}"' not in str(Lab.plot.__doc__)
    ] == []


@pytest.mark.slow
def test_same_log_same_bytes_in_any_process() -> None:
    program = (
        "import sys\nfrom gyrodata import analyze\n"
        "from gyrodata.reporting.figures import render\n"
        "lab = analyze(sys.stdin.buffer.read(), name='log.csv')\n"
        "for form in ('png', 'pdf'):\n    print(render(lab, [form], names=['torque']))\n"
    )
    line, ours = [sys.executable, "-c", program], {**os.environ, "PYTHONHASHSEED": "1"}
    shown = subprocess.run(
        line, input=LOGS["3 x 3"], capture_output=True, check=True, env=ours
    ).stdout.decode()
    lab = analysis_of("3 x 3")
    # `test_the_report_is_written_beside_you` compares the SVG of all figures.
    assert shown.splitlines() == [
        str(render(lab, [form], names=["torque"])) for form in ("png", "pdf")
    ]


def on_axes(analysis: Analysis, name: str) -> tuple[Axes, list[Line2D]]:
    """Draw a figure on axes, and give its marks of runs, a line for each look."""
    ax = Figure().add_subplot()
    assert plot_on(analysis, name, ax) is ax
    return ax, [
        line
        for line in ax.lines
        if line.get_marker() != "None" and len(line.get_xdata())
    ]  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_flagged_run_is_hollow_and_named() -> None:
    analysis = analysis_of("two odd runs")
    assert [run.run for run in analysis.run_table if run.flagged] == ["5", "8"]
    for which in OF_RUNS:
        ax, lines = on_axes(analysis, which)
        assert sum(line.get_markerfacecolor() == "white" for line in lines) == 2
        assert ax.get_legend_handles_labels()[1].count("hollow: left out") == 1
        assert [text.get_text()[:5] for text in ax.texts] == ["run 5", "run 8"]
        assert (
            "Drawn hollow: run 5, left out; run 8, left out."
            in alternatives(analysis)[which]
        )


@pytest.mark.slow
def test_figures_show_the_numbers_of_the_analysis() -> None:
    analysis = analysis_of("3 x 3")
    spins, torques = 30 / np.pi * analysis.runs["spin"], 1e3 * analysis.runs["torque"]
    columns = {
        **analysis.runs,
        "spin": spins,
        "torque": torques,
        "number": range(1, 10),
    }
    shown = {
        "period": ("spin", "period"),
        "product": ("spin", "product"),
        "torque": ("product", "torque"),
        "residuals": ("number", "studentized_residual"),
    }
    assert list(shown) == OF_RUNS
    for name, axes in shown.items():
        lines = on_axes(analysis, name)[1]
        expected = np.column_stack([columns[axis] for axis in axes])
        np.testing.assert_allclose(
            np.concatenate([line.get_xydata() for line in lines[::-1]]), expected
        )
        # Each torque has its own colour and its own symbol, the same in every figure
        # and on the page.
        looks = [
            (line.get_label().partition("\n")[0], line.get_color(), line.get_marker())
            for line in lines[::-1]
        ]
        assert looks == [group.look for group in list_groups(Numbers(analysis))]
        assert [len(set(part)) for part in zip(*looks, strict=True)] == [3, 3, 3]


@pytest.mark.slow
def test_names_from_the_log_are_plain_text() -> None:
    names = [
        "$x^{$",
        "<script>",
        "a very long name of a run",
        "运行",
        "tab\there",
        "\\alpha",
        "run 7",
        "8",
        "9",
    ]
    analysis = analysis_of("3 x 3")
    runs = tuple(
        replace(run, run=name, flagged=True)
        for run, name in zip(analysis.run_table, names, strict=True)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(
            replace(analysis, run_table=runs), ["png", "svg", "pdf"], names=["torque"]
        )
