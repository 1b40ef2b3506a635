"""The figures: they draw for every kind of log, say what they show, and are the same bytes on every run."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
from matplotlib.axis import Axis
from matplotlib.text import Text

from gyrodata import analyze, plotting
from gyrodata.analysis import Analysis

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
    "negative torques": log([20, 40, 60], [200, 400, 600], position=-15),
    "huge": log([20, 40, 60], [200, 400, 600], scale=1e4),
    "tiny": log([20, 40, 60], [200, 400, 600], scale=1e-3),
}


@pytest.fixture(scope="module")
def analyses() -> dict[str, Analysis]:
    return {name: analyze(data, name="log.csv") for name, data in LOGS.items()}


@pytest.mark.parametrize("name", LOGS)
def test_every_kind_of_log_draws_without_a_warning(name: str, analyses: dict[str, Analysis]) -> None:
    files = plotting.render(analyses[name], "png")
    assert tuple(files) == plotting.FIGURES
    assert all(data.startswith(b"\x89PNG") for data in files.values())


@pytest.mark.parametrize("name", LOGS)
def test_text_stays_inside_the_figure_and_labels_apart(name: str, analyses: dict[str, Analysis]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    for which in plotting.FIGURES:
        figure = plotting.draw(analyses[name], which)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        (ax,) = figure.axes
        ticks = [*_tick_labels(ax.xaxis), *_tick_labels(ax.yaxis)]
        texts = [t for t in (*ax.texts, ax.xaxis.label, ax.yaxis.label, *ticks) if t.get_visible()]
        low, high = (0, 0), canvas.get_width_height()
        for text in texts:
            box = text.get_window_extent()
            assert box.x0 >= low[0], (which, text)
            assert box.x1 <= high[0], (which, text)
            assert box.y0 >= low[1], (which, text)
            assert box.y1 <= high[1], (which, text)
        boxes = [t.get_window_extent() for t in ax.texts]
        for i, one in enumerate(boxes):
            for j in range(i):
                across = min(one.x1, boxes[j].x1) - max(one.x0, boxes[j].x0)
                up = min(one.y1, boxes[j].y1) - max(one.y0, boxes[j].y0)
                assert across <= 1 or up <= 3, (which, ax.texts[i], ax.texts[j])
        for axis in (ax.xaxis, ax.yaxis):
            label = axis.label.get_window_extent()
            assert not any(label.overlaps(tick.get_window_extent()) for tick in _tick_labels(axis)), which


def _tick_labels(axis: Axis) -> list[Text]:
    """Labels that are drawn: matplotlib keeps ticks just outside the axes too, unseen."""
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high and tick.label1.get_text()]


@pytest.mark.parametrize("form", ["png", "svg", "pdf"])
def test_same_log_same_bytes_in_any_process(form: str) -> None:
    program = (
        "import sys, hashlib\n"
        "from gyrodata import analyze, plotting\n"
        f"files = plotting.render(analyze(sys.stdin.buffer.read(), name='log.csv'), {form!r})\n"
        "print({name: hashlib.sha256(data).hexdigest() for name, data in files.items()})\n"
    )
    seen = {
        subprocess.run(
            [sys.executable, "-c", program],
            input=LOGS["a miscounted run"],
            capture_output=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }
    assert len(seen) == 1


def test_no_date_in_vector_files(analyses: dict[str, Analysis]) -> None:
    for form in ("svg", "pdf"):
        for data in plotting.render(analyses["3 x 3"], form).values():  # type: ignore[arg-type]
            assert b"CreationDate" not in data
            assert b"dc:date" not in data


def test_a_torque_looks_the_same_in_every_figure(analyses: dict[str, Analysis]) -> None:
    looks = []
    for name in plotting.FIGURES:
        (ax,) = plotting.draw(analyses["nine torques"], name).axes
        lines = [line for line in ax.lines if line.get_linestyle() == "None" and len(line.get_xdata()) == 3]
        looks.append([(line.get_color(), line.get_marker()) for line in lines])
    assert len(set(looks[0])) == 9
    assert all(look == looks[0] for look in looks)


def test_a_flagged_run_is_hollow_and_named_everywhere(analyses: dict[str, Analysis]) -> None:
    analysis = analyses["a miscounted run"]
    assert [run.run for run in analysis.run_table if run.flagged] == ["5"]
    for name in plotting.FIGURES:
        (ax,) = plotting.draw(analysis, name).axes
        assert any(line.get_markerfacecolor() == "white" for line in ax.lines), name
        assert any(text.get_text().startswith("run 5") for text in ax.texts), name
        assert "run 5" in plotting.alt_text(analysis, name)


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
    np.testing.assert_allclose(y, 1e3 * (analysis.inertia.value * x - analysis.imbalance.value))


@pytest.mark.parametrize("name", plotting.FIGURES)
def test_alt_text_tells_the_main_numbers(name: str, analyses: dict[str, Analysis]) -> None:
    text = plotting.alt_text(analyses["3 x 3"], name)
    expected = {"period": "rpm", "product": "rad²/s²", "torque": "kg·m²", "residuals": "9 runs"}[name]
    assert expected in text
    assert len(text) < 700
