"""The figures: they draw for every kind of log, say what they show, and are the same bytes on every run."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from itertools import combinations

import numpy as np
import pytest

from gyrodata import analyze, plotting
from gyrodata.plotting import choose_looks
from gyrodata.plotting.sheet import Dots, Panel, Sheet, Strokes, Words
from gyrodata.results import Analysis

HEADER = "run,mass [g],position [cm],spin [rpm],time [s],turns"


def log(
    masses: list[float], spins: list[float], position: float = 15.0, scale: float = 1.0, wrong: int = -1,
    names: list[str] | None = None,
) -> bytes:  # fmt: skip
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
    "nine torques": log([20, 30, 40, 50, 60, 70, 80, 90, 100], [200, 400, 600]),
    "sixty torques": log([10 + 2 * i for i in range(60)], [300]),
    "a miscounted run": log([20, 40, 60], [200, 400, 600], wrong=4),
    "two odd runs": log([20, 40, 60], [200, 400, 600], wrong=4).replace(b'"8",60,15.0,400,13', b'"8",60,15.0,400,16'),
    "both senses": log([2, 4, 6], [200, 400, 600], position=900).replace(b"2,900,200,", b"2,-900,200,"),
    "long numbers": log([20, 40, 60], [200, 400, 600], position=-15, scale=50),
    "tiny": log([20, 40, 60], [200, 400, 600], scale=1e-3),
}


@pytest.fixture(scope="module")
def analyses() -> dict[str, Analysis]:
    return {name: analyze(data, name="log.csv") for name, data in LOGS.items()}


def check_layout(sheet: Sheet) -> None:
    """All text inside the figure, no two texts on one another, none on the frame's lines, no name on a dot."""
    texts = [item for item in sheet.items if isinstance(item, Words)]
    for text in texts:
        box = text.box
        assert 0 <= box.left <= box.left + box.wide <= sheet.wide, text
        assert 0 <= box.bottom <= box.bottom + box.tall <= sheet.tall, text
    for one, other in combinations(texts, 2):
        first, second = one.box, other.box
        across = min(first.left + first.wide, second.left + second.wide) - max(first.left, second.left)
        up = min(first.bottom + first.tall, second.bottom + second.tall) - max(first.bottom, second.bottom)
        assert across <= 1 or up <= 1.5, (one, other)
    for panel in sheet.panels:
        dots = np.concatenate([places for places, _ in runs(sheet, panel)])
        for text in texts:
            if text.name:
                middle = [text.box.left + text.box.wide / 2, text.box.bottom + text.box.tall / 2]
                inside = (abs(dots - middle) < [text.box.wide / 2, 4]).all(axis=1)
                assert not inside.any(), text


def runs(sheet: Sheet, panel: Panel) -> list[tuple[np.ndarray, Dots]]:
    """Places of the runs on a panel [point], without the marks of the labels beside it."""
    left, bottom, wide, tall = panel.box
    found = []
    for item in sheet.items:
        if isinstance(item, Dots):
            low, high = [left - 1, bottom - 1], [left + wide + 1, bottom + tall + 1]
            if ((item.at >= low) & (item.at <= high)).all():
                found.append((item.at, item))
    return found


def told(sheet: Sheet) -> list[str]:
    return [item.text for item in sheet.items if isinstance(item, Words)]


def data(panel: Panel, places: np.ndarray) -> np.ndarray:
    """What stands at places of linear axes."""
    shares = (places - panel.box[:2]) / panel.box[2:]
    ends = np.array([panel.x, panel.y])
    return ends[:, 0] + shares * (ends[:, 1] - ends[:, 0])


@pytest.mark.parametrize("medium", plotting.MEDIA)
@pytest.mark.parametrize("name", LOGS)
def test_texts_of_any_log_are_inside_and_apart(name: str, medium: str, analyses: dict[str, Analysis]) -> None:
    if medium == "screen" or name in ("nine torques", "two odd runs", "with unloaded runs"):
        for which in plotting.FIGURES:
            check_layout(plotting.draw(analyses[name], which, plotting.MEDIA[medium]))


def test_same_log_same_bytes_in_any_process() -> None:
    program = (
        "import sys, hashlib\n"
        "from gyrodata import analyze, plotting\n"
        "lab = analyze(sys.stdin.buffer.read(), name='log.csv')\n"
        "for form in ('png', 'svg', 'pdf'):\n"
        "    print([hashlib.sha256(data).hexdigest() for data in plotting.render(lab, form).values()])\n"
    )
    hashes = [
        subprocess.run(
            [sys.executable, "-c", program], input=LOGS["a miscounted run"], capture_output=True, check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    ]  # fmt: skip
    assert hashes[0] == hashes[1]
    assert hashes[0].count(b"\n") == 3


@pytest.mark.parametrize("name", ["a miscounted run", "two odd runs"])
def test_a_flagged_run_is_hollow_and_named_everywhere(name: str, analyses: dict[str, Analysis]) -> None:
    analysis = analyses[name]
    flagged = [run.run for run in analysis.run_table if run.flagged]
    assert flagged == (["5"] if name == "a miscounted run" else ["5", "8"])
    for which in plotting.FIGURES:
        sheet = plotting.draw(analysis, which)
        for panel in sheet.panels:
            assert sum(len(places) for places, dots in runs(sheet, panel) if dots.hollow) == len(flagged)
        for run in flagged:
            assert sum(text.startswith(f"run {run}") for text in told(sheet)) == len(sheet.panels)
            assert f"run {run}" in plotting.alt_text(analysis, which)


# Colours as the colour-blind see them: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE Trans. Vis. Comput.
# Graph. 15 (2009) 1291, severity 1, for linear red, green and blue.
SIGHT = {
    "normal": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
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
    seen = [lab(colour, np.array(SIGHT[sight])) for colour in colours]
    apart = min(np.linalg.norm(a - b) for a, b in combinations(seen, 2))
    # Six times the least difference that is seen of two patches side by side.
    assert apart > 15


def test_names_from_the_log_are_plain_text() -> None:
    names = ["$x^{", "<script>", "a very long name of a run", "运行", "tab\there", "\\alpha", "run 7", "8", "9"]
    analysis = analyze(log([20, 40, 60], [200, 400, 600], wrong=3, names=names), name="log.csv")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for form in ("png", "svg", "pdf"):
            plotting.render(analysis, form)  # type: ignore[arg-type]


def test_figures_hold_the_numbers_of_the_analysis(analyses: dict[str, Analysis]) -> None:
    analysis = analyses["3 x 3"]
    sheet = plotting.draw(analysis, "period")
    (panel,) = sheet.panels
    shown = data(panel, np.concatenate([places for places, _ in runs(sheet, panel)]))
    np.testing.assert_allclose(shown, [(run.spin * 30 / np.pi, run.period) for run in analysis.run_table])
    sheet = plotting.draw(analysis, "torque")
    upper, lower = sheet.panels
    strokes = [item for item in sheet.items if isinstance(item, Strokes) and item.clip == upper.box]
    line = next(data(upper, item.lines[0]) for item in strokes if item.width == 1.2)
    np.testing.assert_allclose(line[:, 1], 1e3 * (analysis.inertia.value * line[:, 0] - analysis.residual_torque.value))
    torque = 1e3 * np.array([run.torque for run in analysis.run_table])
    product = np.array([run.product for run in analysis.run_table])
    above = data(upper, np.concatenate([places for places, _ in runs(sheet, upper)]))
    np.testing.assert_allclose(above, np.column_stack([product, torque]))
    left = torque - 1e3 * (analysis.inertia.value * product - analysis.residual_torque.value)
    below = data(lower, np.concatenate([places for places, _ in runs(sheet, lower)]))
    np.testing.assert_allclose(below, np.column_stack([product, left]), atol=1e-9)
