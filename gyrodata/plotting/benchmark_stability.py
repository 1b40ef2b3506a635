"""Where methods break: maps of correct digits, orbits near the vertical, and logs that fits make nonsense of."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata.benchmark.breakdowns import Breakdown, Verdict
from gyrodata.benchmark.maps import MOST_DIGITS, DigitMap, MapPair
from gyrodata.benchmark.upright import METHODS, Passage
from gyrodata.plotting.benchmark_labels import head, log_axis, percent_text, power_text
from gyrodata.plotting.marks import INK, SOFT, log_ticks
from gyrodata.plotting.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EMPTY = "#bbbbbb"


# --- maps ---------------------------------------------------------------------------------------------------


def draw_maps(pairs: Sequence[MapPair]) -> Figure:
    """Draw maps of correct digits, a row a pair: what fails on the left, what holds on the right.

    Parameters
    ----------
    pairs : sequence of MapPair

    Returns
    -------
    matplotlib.figure.Figure
        9 inches wide.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        height = 0.35 + 2.65 * len(pairs)
        figure = Figure(figsize=(9.0, height), dpi=150)
        shown: Any = None
        for row, pair in enumerate(pairs):
            bottom = (height - 2.65 * (row + 1) + 0.4) / height
            for column, (one, says) in enumerate(((pair.fails, "fails"), (pair.holds, "holds"))):
                ax = figure.add_axes((0.078 + 0.435 * column, bottom, 0.36, 1.85 / height))
                shown = _draw_map(ax, pair, one, first=column == 0, last=row == len(pairs) - 1)
                head(ax, f"{says}: {one.method}", pair.title)
        bar = figure.add_axes((0.905, 0.4 / height, 0.016, (height - 1.2) / height))
        figure.colorbar(shown, cax=bar, ticks=[0, 4, 8, 12, 16])
        bar.set_ylabel("correct digits", fontsize=9)
        bar.tick_params(length=3)
    return figure


def _draw_map(ax: Axes, pair: MapPair, one: DigitMap, first: bool, last: bool) -> Any:
    ax.set_facecolor(_EMPTY)
    # Rasterised: an SVG of thousands of squares is slow to show.
    mesh = ax.pcolormesh(pair.x, pair.y, np.ma.masked_invalid(one.digits), cmap="cividis", vmin=0, vmax=MOST_DIGITS,
                         shading="nearest", rasterized=True)  # fmt: skip
    ax.set_xscale("log")
    log_axis("x", ax, ticks := log_ticks(float(pair.x[0]), float(pair.x[-1])), [f"{tick:g}" for tick in ticks])
    if last:
        ax.set_xlabel(pair.x_label)
    if first:
        ax.set_ylabel(pair.y_label)
    empty = np.isnan(one.digits).sum(axis=1)
    if pair.empty and np.mean(empty > 0) > 0.2:
        # Where the region is widest; it begins at the lowest spins.
        heights = pair.y[empty > 0.9 * empty.max()]
        ax.text(
            float(pair.x[1]),
            float(heights.mean()),
            pair.empty.replace("steady ", "steady\n"),
            fontsize=7.5,
            color=INK,
            va="center",
        )
    return mesh


# --- near the vertical --------------------------------------------------------------------------------------

_COLOURS = ("#D55E00", "#CC79A7", "#0072B2", "#E69F00", "#009E73")


def draw_upright(passages: Sequence[Passage]) -> Figure:
    """Draw what orbits that pass near the vertical cost, and how wrong they come out.

    Parameters
    ----------
    passages : sequence of Passage

    Returns
    -------
    matplotlib.figure.Figure
        9 × 3.7 inches.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.7), dpi=150)
        left = figure.add_axes((0.075, 0.15, 0.29, 0.68))
        right = figure.add_axes((0.555, 0.15, 0.29, 0.68))
        started = [one.method for one in passages if one.closest == 0 and one.error is None]
        _draw_lines(left, [(one.method, one.closest, one.error) for one in passages if one.closest])
        head(left, "error of the rod's direction in 10 s", f"started at the vertical, no answer: {_listed(started)}")
        _draw_lines(right, [(one.method, one.closest, one.evaluations) for one in passages if one.closest])
        head(right, "evaluations for 10 s", "of the right-hand side by DOP853, rtol 1e-9; of the torque in splitting")
    return figure


def _listed(names: Sequence[str]) -> str:
    return "; ".join(names) or "none"


def _draw_lines(ax: Axes, values: Sequence[tuple[str, float, float | None]]) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    told = [(method, x, y) for method, x, y in values if y is not None]
    xs, ys = [x for _, x, _ in told], [y for _, _, y in told]
    ax.set_xlim(max(xs) * 3, min(xs) / 3)
    ax.set_ylim(min(ys) / 6, max(ys) * 6)
    for method, colour in zip(METHODS, _COLOURS, strict=True):
        points = [(x, y) for name, x, y in told if name == method]
        if points:
            ax.plot(*zip(*points, strict=True), color=colour, marker="o", markersize=4, linewidth=1.2)
    ends = {method: y for method, _, y in told}
    for method, height in zip(ends, _apart([_height(ax, y) for y in ends.values()], 0.065), strict=True):
        colour = _COLOURS[METHODS.index(method)]
        ax.plot([1.0, 1.035], [_height(ax, ends[method]), height], color=colour, linewidth=0.8, clip_on=False,
                transform=ax.transAxes)  # fmt: skip
        ax.text(1.045, height, method, transform=ax.transAxes, fontsize=8, color=INK, va="center")
    powers = [10.0**power for power in range(-16, 7)]
    log_axis(
        "x", ax, shown := [p for p in powers if min(xs) * 0.9 <= p <= max(xs)][::2], [power_text(p) for p in shown]
    )
    log_axis("y", ax, shown := [p for p in powers if min(ys) / 3 <= p <= max(ys) * 3], [power_text(p) for p in shown])
    ax.set_xlabel("smallest angle from the vertical [rad]")


def _height(ax: Axes, y: float) -> float:
    """Where a value is on an axis, 0 to 1."""
    return float(ax.transAxes.inverted().transform(ax.transData.transform((1.0, y)))[1])


def _apart(heights: Sequence[float], gap: float) -> list[float]:
    """Move heights up until each is a gap above the one below it."""
    placed = list(heights)
    order = sorted(range(len(placed)), key=lambda i: placed[i])
    for low, high in pairwise(order):
        placed[high] = max(placed[high], placed[low] + gap)
    return placed


# --- fits ---------------------------------------------------------------------------------------------------

_VERDICTS: dict[Verdict, tuple[str, str, str]] = {
    "holds": ("#0072B2", "white", "holds"),
    "wide": ("#56B4E9", INK, "holds, but ± over 50 %"),
    "says so": ("#eeeeee", INK, "no answer, and says so"),
    "too sure": ("#E69F00", INK, "interval too small"),
    "nonsense": ("#D55E00", "white", "nonsense, silently"),
}
"""Ground, ink and words of each verdict."""


def draw_breakdowns(breakdowns: Sequence[Breakdown]) -> Figure:
    """Draw what each estimator makes of each kind of broken log.

    Parameters
    ----------
    breakdowns : sequence of Breakdown

    Returns
    -------
    matplotlib.figure.Figure
        9 inches wide; in each cell the median error of I_zz.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    cases = list(dict.fromkeys(one.case for one in breakdowns))
    estimators = list(dict.fromkeys(one.estimator for one in breakdowns))
    with rc_context(STYLE):
        height = 1.05 + 0.29 * len(estimators)
        figure = Figure(figsize=(9.0, height), dpi=150)
        ax = figure.add_axes((0.16, 0.42 / height, 0.83, 0.29 * len(estimators) / height))
        ax.set_xlim(0, len(cases))
        ax.set_ylim(len(estimators), 0)
        for one in breakdowns:
            _draw_cell(ax, cases.index(one.case), estimators.index(one.estimator), one)
        ax.xaxis.set_ticks([i + 0.5 for i in range(len(cases))], [_folded(case) for case in cases])
        ax.xaxis.tick_top()
        ax.yaxis.set_ticks([i + 0.5 for i in range(len(estimators))], estimators)
        ax.text(-0.02, -0.55, "median error\nof I_zz", fontsize=8, color=SOFT, ha="right", va="center")
        ax.tick_params(length=0, labelsize=8)
        for side in ("left", "bottom"):
            ax.spines[side].set_visible(False)
        key = figure.add_axes((0.16, 0.0, 0.83, 0.36 / height))
        _draw_verdicts(key)
    return figure


def _folded(text: str) -> str:
    """Break a name of two words or more in two lines."""
    words = text.split(" ")
    half = (len(words) + 1) // 2
    return " ".join(words[:half]) + "\n" + " ".join(words[half:])


def _draw_cell(ax: Axes, column: int, row: int, one: Breakdown) -> None:
    from matplotlib.patches import Rectangle

    ground, ink, _ = _VERDICTS[one.verdict]
    ax.add_patch(Rectangle((column + 0.02, row + 0.05), 0.96, 0.9, facecolor=ground, linewidth=0))
    text = "–" if one.error is None or one.verdict == "says so" else _error_text(one.error)
    ax.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=8, color=ink)


def _error_text(error: float) -> str:
    if error > 9.995:
        return "× 10 and more"
    return percent_text(error)


def _draw_verdicts(ax: Axes) -> None:
    from matplotlib.patches import Rectangle

    ax.set_axis_off()
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    x = 0.0
    for ground, _, words in _VERDICTS.values():
        ax.add_patch(Rectangle((x, 0.3), 0.018, 0.4, facecolor=ground, edgecolor=SOFT, linewidth=0.4))
        ax.text(x + 0.024, 0.5, words, fontsize=8, va="center", color=INK)
        x += 0.045 + 0.0085 * len(words)
