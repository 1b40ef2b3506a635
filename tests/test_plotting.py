"""The figures: they draw for every kind of log, say what they show, and are the same bytes on every run."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
import warnings
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text
from PIL import Image

from gyrodata import analyze, plotting
from gyrodata.plotting import choose_looks
from gyrodata.plotting.marks import save
from gyrodata.results import Analysis

HEADER = "run,mass [g],position [cm],spin [rpm],time [s],turns"


def log(
    masses: list[float],
    spins: list[float],
    position: float = 15.0,
    scale: float = 1.0,
    wrong: int | None = None,
    names: list[str] | None = None,
) -> bytes:
    """A log without noise but for a fixed ± 0.1 s; `scale` multiplies I_zz and the masses."""
    rows = ["# g: 9.803 m/s^2", HEADER]
    for number, (mass, spin) in enumerate((m, s) for m in masses for s in spins):
        torque = 1e-3 * mass * scale * 9.803 * 1e-2 * position + 0.0007 * scale * np.sign(position)
        period = 2 * np.pi * 0.00444 * scale * spin * np.pi / 30 / abs(torque)
        turns = "1" if period < 90 else "1/3"
        time = period * (1 if turns == "1" else 1 / 3) + 0.1 * (-1) ** number
        if number == wrong:
            turns = "2"
        name = names[number] if names else str(number + 1)
        place = f"{position}" if mass else ""
        rows.append(f'"{name}",{mass * scale:.6g},{place},{spin},{time:.2f},{turns}')
    return "\n".join(rows).encode() + b"\n"


LOGS = {
    "3 x 3": log([20, 40, 60], [200, 400, 600]),
    "with unloaded runs": log([20, 40, 60, 0], [200, 400, 600]),
    "one torque": log([50], [150, 300, 450, 600]),
    "one run": log([50], [400]),
    "one run a torque": log([20, 30, 40, 50], [400]),
    "nine torques": log([20, 30, 40, 50, 60, 70, 80, 90, 100], [200, 400, 600]),
    "twenty torques": log([10 + 5 * i for i in range(20)], [150, 250, 350, 500, 650]),
    "sixty torques": log([10 + 2 * i for i in range(60)], [300]),
    "a miscounted run": log([20, 40, 60], [200, 400, 600], wrong=4),
    "two odd runs": log([20, 40, 60], [200, 400, 600], wrong=4).replace(b'"8",60,15.0,400,13', b'"8",60,15.0,400,16'),
    "negative torques": log([20, 40, 60], [200, 400, 600], position=-15),
    "huge": log([20, 40, 60], [200, 400, 600], scale=1e4),
    "tiny": log([20, 40, 60], [200, 400, 600], scale=1e-3),
}


@pytest.fixture(scope="module")
def analyses() -> dict[str, Analysis]:
    return {name: analyze(data, name="log.csv") for name, data in LOGS.items()}


def check_layout(figure: Figure) -> None:
    """All text inside the figure, no two texts on one another, no tick on its axis' label, no name on a dot."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (ax,) = figure.axes
    ticks = [*_tick_labels(ax.xaxis), *_tick_labels(ax.yaxis)]
    high = canvas.get_width_height()
    for text in (*ax.texts, ax.xaxis.label, ax.yaxis.label, *ticks):
        # Of an annotation the text alone, without the line that ties it to its dot.
        box = Text.get_window_extent(text)
        assert 0 <= box.x0 <= box.x1 <= high[0], text
        assert 0 <= box.y0 <= box.y1 <= high[1], text
    texts = [*ax.texts, ax.xaxis.label, ax.yaxis.label]
    boxes = [Text.get_window_extent(text) for text in texts]
    point = figure.dpi / 72
    for i, one in enumerate(boxes):
        for j in range(i):
            across = min(one.x1, boxes[j].x1) - max(one.x0, boxes[j].x0)
            up = min(one.y1, boxes[j].y1) - max(one.y0, boxes[j].y0)
            assert across <= point or up <= 1.5 * point, (texts[i], texts[j])
    for axis in (ax.xaxis, ax.yaxis):
        label = axis.label.get_window_extent()
        assert not any(label.overlaps(tick.get_window_extent()) for tick in _tick_labels(axis))
    dots = np.concatenate([line.get_transform().transform(line.get_xydata()) for line in _dots(ax)])
    for name in ax.texts:
        if isinstance(name, Annotation):
            box = Text.get_window_extent(name)
            inside = (abs(dots - [(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2]) < [box.width / 2, 4 * point]).all(
                axis=1
            )
            assert not inside.any(), name


def _dots(ax: Axes) -> list[Line2D]:
    """Runs, not the marks of the labels beside the axes."""
    return [line for line in ax.lines if line.get_linestyle() == "None" and line.get_transform() == ax.transData]


@pytest.mark.parametrize("which", plotting.FIGURES)
@pytest.mark.parametrize("name", LOGS)
def test_every_kind_of_log_draws_without_a_warning_or_an_overlap(
    name: str, which: str, analyses: dict[str, Analysis]
) -> None:
    check_layout(plotting.draw(analyses[name], which))


@pytest.mark.parametrize("name", ["nine torques", "two odd runs", "with unloaded runs"])
def test_slides_have_larger_letters_and_no_overlap(name: str, analyses: dict[str, Analysis]) -> None:
    for which in plotting.FIGURES:
        figure = plotting.draw(analyses[name], which, plotting.MEDIA["slides"])
        check_layout(figure)
        assert figure.get_size_inches()[1] < plotting.draw(analyses[name], which).get_size_inches()[1]


def test_dots_to_the_inch(analyses: dict[str, Analysis]) -> None:
    sizes = {}
    for name, medium in plotting.MEDIA.items():
        image = Image.open(io.BytesIO(save(plotting.draw(analyses["3 x 3"], "torque", medium), "png")))
        sizes[name] = image.size
        assert image.info["dpi"] == pytest.approx((medium.dpi, medium.dpi), abs=0.02)
        assert image.getpixel((0, 0)) == image.getpixel((image.width - 1, image.height - 1))
        assert image.convert("RGB").getpixel((0, 0)) == (255, 255, 255)
    assert sizes == {"screen": (990, 630), "slides": (1920, 1080), "print": (1980, 1260)}


def _tick_labels(axis: Axis) -> list[Text]:
    """Labels that are drawn: matplotlib keeps ticks just outside the axes too, unseen."""
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high and tick.label1.get_text()]


@pytest.mark.parametrize(("style", "size"), [("slides", (1920, 1080)), ("print", (1980, 1260))])
def test_the_command_draws_for_slides_and_print(style: str, size: tuple[int, int], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "gyrodata", "analyze", "-", "--style", style, "--out", str(tmp_path), "--quiet"]
    subprocess.run(command, input=LOGS["3 x 3"], stdout=subprocess.DEVNULL, check=True)
    with Image.open(tmp_path / "torque.png") as image:
        assert image.size == size
    medium = plotting.MEDIA[style]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for look in plotting.list_looks(analyze(LOGS["3 x 3"], name="log.csv"), medium.grey_safe):
        assert f'fill="{look.colour}"' in page


def test_same_log_same_bytes_in_any_process() -> None:
    program = (
        "import sys, hashlib\n"
        "from gyrodata import analyze, plotting\n"
        "lab = analyze(sys.stdin.buffer.read(), name='log.csv')\n"
        "for form in ('png', 'svg', 'pdf'):\n"
        "    print([hashlib.sha256(data).hexdigest() for data in plotting.render(lab, form).values()])\n"
    )
    running = [
        subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        for seed in ("1", "2")
    ]
    told = [process.communicate(LOGS["a miscounted run"])[0] for process in running]
    assert told[0] == told[1]
    assert told[0].count(b"\n") == 3


def test_no_date_in_vector_files(analyses: dict[str, Analysis]) -> None:
    for form in ("svg", "pdf"):
        for data in plotting.render(analyses["3 x 3"], form).values():  # type: ignore[arg-type]
            assert b"CreationDate" not in data
            assert b"dc:date" not in data


@pytest.mark.parametrize("name", ["3 x 3", "nine torques"])
def test_a_torque_looks_the_same_in_every_figure_and_like_no_other(name: str, analyses: dict[str, Analysis]) -> None:
    told = [(look.colour, look.marker) for look in plotting.list_looks(analyses[name])]
    assert len({colour for colour, _ in told}) == len(told)
    for which in plotting.FIGURES:
        (ax,) = plotting.draw(analyses[name], which).axes
        assert [(line.get_color(), line.get_marker()) for line in _dots(ax)] == told


@pytest.mark.parametrize("name", ["a miscounted run", "two odd runs"])
def test_a_flagged_run_is_hollow_and_named_everywhere(name: str, analyses: dict[str, Analysis]) -> None:
    analysis = analyses[name]
    flagged = [run.run for run in analysis.run_table if run.flagged]
    assert flagged == (["5"] if name == "a miscounted run" else ["5", "8"])
    for which in plotting.FIGURES:
        (ax,) = plotting.draw(analysis, which).axes
        hollow = [line for line in _dots(ax) if line.get_markerfacecolor() == "white"]
        assert sum(len(line.get_xdata()) for line in hollow) == len(flagged)
        for run in flagged:
            assert any(text.get_text().startswith(f"run {run}") for text in ax.texts), which
            assert f"run {run}" in plotting.alt_text(analysis, which)


def test_what_lies_beyond_the_axes_says_where_it_is(analyses: dict[str, Analysis]) -> None:
    (ax,) = plotting.draw(analyses["with unloaded runs"], "period").axes
    beyond = [text.get_text() for text in ax.texts if "↑" in text.get_text()]
    unloaded = [run for run in analyses["with unloaded runs"].run_table if not run.torque]
    assert beyond == [f"↑ {run.period:.4g} s" for run in unloaded]
    assert ax.get_ylim()[1] < 100
    (ax,) = plotting.draw(analyses["two odd runs"], "residuals").axes
    assert any(re.fullmatch(r"run 5 ↓ −\d+ u", text.get_text()) for text in ax.texts)


# Colours as the colour-blind see them: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE Trans. Vis. Comput.
# Graph. 15 (2009) 1291, severity 1, for linear red, green and blue.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}


def lab(colour: str, sight: np.ndarray) -> np.ndarray:
    """CIE L*a*b* (D65) of a colour as one sees it."""
    values = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
    )
    xyz = to_xyz @ np.clip(sight @ linear, 0, 1) / [0.95047, 1.0, 1.08883]
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_stay_apart_for_the_colour_blind(sight: str) -> None:
    colours = [colour for colour, _ in choose_looks([0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.0])]
    seen = [lab(colour, SIGHT[sight]) for colour in colours]
    apart = min(np.linalg.norm(a - b) for a, b in combinations(seen, 2))
    # Six times the least difference that is seen of two patches side by side.
    assert apart > 15


def test_print_shades_differ_without_colour() -> None:
    for count in (2, 3, 4, 6):
        looks = choose_looks([0.01 * (i + 1) for i in range(count)], grey_safe=True)
        lightness = [lab(colour, SIGHT["normal"])[0] for colour, _ in looks]
        assert lightness == sorted(lightness)
        assert min(np.diff(lightness)) > 7
        assert len({marker for _, marker in looks}) == count


def test_names_from_the_log_are_plain_text() -> None:
    names = ["$x^{", "<script>", "a very long name of a run", "运行", "tab\there", "\\alpha", "run 7", "8", "9"]
    analysis = analyze(log([20, 40, 60], [200, 400, 600], wrong=3, names=names), name="log.csv")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for form in ("png", "svg", "pdf"):
            plotting.render(analysis, form)  # type: ignore[arg-type]


def test_a_style_of_the_user_survives() -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    plotting.render(analyze(LOGS["one run"], name="log.csv"))
    assert dict(mpl.rcParams) == before


def test_no_pyplot() -> None:
    program = (
        "import sys\nfrom gyrodata import analyze, plotting\n"
        "assert 'matplotlib' not in sys.modules\n"
        "plotting.render(analyze(sys.stdin.buffer.read(), name='log.csv'))\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", program], input=LOGS["3 x 3"], check=True)


def test_figures_hold_the_numbers_of_the_analysis(analyses: dict[str, Analysis]) -> None:
    analysis = analyses["3 x 3"]
    (ax,) = plotting.draw(analysis, "period").axes
    dots = [line for line in ax.lines if line.get_linestyle() == "None" and len(line.get_xdata()) == 3]
    spins = np.concatenate([line.get_xdata() for line in dots])
    periods = np.concatenate([line.get_ydata() for line in dots])
    np.testing.assert_allclose(spins, [run.spin * 30 / np.pi for run in analysis.run_table])
    np.testing.assert_allclose(periods, [run.period for run in analysis.run_table])
    (ax,) = plotting.draw(analysis, "torque").axes
    line = max(ax.lines, key=lambda line: len(line.get_xdata()))
    x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    np.testing.assert_allclose(y, 1e3 * (analysis.inertia.value * x - analysis.residual_torque.value))


@pytest.mark.parametrize("name", plotting.FIGURES)
def test_alt_text_tells_the_main_numbers(name: str, analyses: dict[str, Analysis]) -> None:
    text = plotting.alt_text(analyses["3 x 3"], name)
    expected = {"period": "rpm", "product": "rad²/s²", "torque": "kg·m²", "residuals": "9 runs"}[name]
    assert expected in text
    assert len(text) < 700
