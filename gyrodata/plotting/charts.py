"""The charts of `gyro benchmark`: time against error, and where methods break."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata.benchmark import (
    BATCH,
    CHARTED,
    HONEST,
    METHODS,
    MOST_DIGITS,
    TAKE_BALANCE,
    TIE,
    Benchmark,
    Breakdown,
    DigitCurve,
    DigitMap,
    Drift,
    FitCurve,
    MapPair,
    MotionPanel,
    MotionPoint,
    Order,
    Passage,
    Trial,
    TrialPanel,
    Verdict,
    percent_text,
    time_text,
)
from gyrodata.physics import Floats
from gyrodata.plotting.marks import NAME_SIZE, log_ticks, place_names, spread
from gyrodata.plotting.sheet import INK, METADATA, SOFT, Form, write_png
from gyrodata.plotting.sheet import STYLE as PLAIN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


STYLE: Any = {
    **PLAIN,
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.5,
    "axes.axisbelow": True,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
}
"""For matplotlib's ``rc_context``, around drawing and saving."""


def draw_chart(benchmark: Benchmark, name: str) -> Figure:
    """Draw one chart, 9 inches wide: of the motion, of the estimators, or one of those of stability."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        figure = _DRAWERS[name](benchmark)
        _write_machine(figure, benchmark.machine)
    return figure


def render_benchmark(benchmark: Benchmark, forms: Sequence[Form] = ("png", "svg")) -> dict[str, bytes]:
    """Draw every chart as files, by name: the same bytes for the same benchmark; a PNG is 1350 dots wide."""
    from matplotlib import rc_context

    files: dict[str, bytes] = {}
    with rc_context(STYLE):
        for name in _DRAWERS:
            figure = draw_chart(benchmark, name)
            files |= {f"{name}.{form}": save(figure, form) for form in forms}
    return files


def save(figure: Figure, form: Form) -> bytes:
    """Write a chart as a file, within ``rc_context(STYLE)``."""
    if form == "png":
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
        return write_png(np.asarray(canvas.buffer_rgba()), figure.dpi)
    file = io.BytesIO()
    figure.savefig(file, format=form, metadata=METADATA[form])
    return file.getvalue()


def _figure(height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(9.0, height), dpi=150)


def _write_machine(figure: Figure, machine: str) -> None:
    """Write on what machine the numbers were measured, on a strip below all else."""
    if not machine:
        return
    width, height = figure.get_size_inches()
    strip = 0.2  # inches
    figure.set_size_inches(width, height + strip)
    for ax in figure.axes:
        box = ax.get_position()
        bottom, tall = (box.y0 * height + strip) / (height + strip), box.height * height / (height + strip)
        ax.set_position((box.x0, bottom, box.width, tall))
    figure.text(0.012, 0.07 / (height + strip), machine, fontsize=6.5, color=SOFT)


def _log_axes(ax: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Make both axes logarithmic, with these limits."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(x)
    ax.set_ylim(y)


def _write_ticks(ax: Axes, axis: str, values: Sequence[float], text: Callable[[float], str]) -> None:
    """Put written ticks on a logarithmic axis, "x" or "y", and no others."""
    which = ax.xaxis if axis == "x" else ax.yaxis
    which.set_ticks(list(values), [text(value) for value in values])
    which.set_ticks([], minor=True)
    ax.tick_params(length=3)


def _power_text(value: float) -> str:
    """Write a power of ten: 10⁻⁴."""
    return "10" + str(round(math.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _key_axes(figure: Figure, place: tuple[float, float, float, float]) -> Axes:
    """Make room for a key: axes from 0 to 1 that are not seen."""
    ax = figure.add_axes(place)
    ax.set_axis_off()
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    return ax


def head(ax: Axes, title: str, note: str) -> None:
    """Write the title of one panel of several, and a line of small print below it, from the axes' left edge."""
    tall = 72 * ax.bbox.height / ax.figure.dpi
    for words, up, size, weight, colour in ((title, 14, 9, "bold", INK), (note, 4, 7.5, "normal", SOFT)):
        ax.text(0.0, 1 + up / tall, words, transform=ax.transAxes, fontsize=size, weight=weight, color=colour)


def draw_key(ax: Axes, x: Sequence[float], y: Sequence[float], text: str, gap: float, **look: Any) -> None:
    """Draw one entry of a key, in parts of the axes: a mark or a stroke through (x, y), and what it is right of it."""
    ax.plot(x, y, transform=ax.transAxes, **look)
    ax.text(x[-1] + gap, y[-1], text, transform=ax.transAxes, va="center", fontsize=8.0, color=INK)


def name_dots(ax: Axes, x: Floats, y: Floats, names: Mapping[int, str], bold: Collection[int] = ()) -> None:
    """Write names beside dots, on a white ground, tied to their dots where they stand apart; bold ones first."""
    to_points = 72 / ax.figure.dpi
    dots = ax.transData.transform(np.column_stack([x, y])) * to_points
    line = {"arrowstyle": "-", "color": SOFT, "linewidth": 0.5, "shrinkA": 1, "shrinkB": 3}
    for i, place in place_names(dots, np.array(ax.bbox.extents) * to_points, names, bold).items():
        ax.annotate(
            names[i],
            (x[i], y[i]),
            tuple(place.middle - dots[i]),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=NAME_SIZE,
            color=INK,
            weight="bold" if i in bold else "normal",
            annotation_clip=False,
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.2},
            arrowprops=line if place.apart else None,
            zorder=6,
        )


# --- motion: time against error -----------------------------------------------------------------------------

_LOOKS = {
    "eq. (9)": ("#0072B2", "o", "none"),
    "eq. (9), plain mean spin": ("#0072B2", "v", "none"),
    "eq. (9), spin at start": ("#0072B2", "^", "none"),
    "eq. (8)": ("#D55E00", "s", "none"),
    "mean rate": ("#CC79A7", "D", "none"),
    "exact motion": ("#009E73", "P", "none"),
    "splitting strang": ("#E69F00", "<", "-"),
    "splitting aba84": ("#E69F00", ">", "-"),
    "RK4": ("#D55E00", "v", "--"),
    "implicit midpoint": ("#CC79A7", "p", "--"),
    "RKMK4": ("#009E73", "d", "--"),
    "RK45": ("#56B4E9", "X", "-"),
    "Tsit5": ("#0072B2", "h", "-"),
    "DOP853": ("#000000", "o", "-"),
    "LSODA": ("#777777", "s", "-"),
    "Radau": ("#777777", "^", "-"),
}
"""Colour, marker and line of each method: Okabe and Ito's set, told apart by markers too; dashed: a fixed step."""

_FLOOR = 1e-16
"""Smaller errors are drawn here."""

_HOW_TO_READ = """\
Left-most under the band wins (ringed). Band: 0.3 u to u of I_zz in a lab of nine runs. Errors below 10⁻¹⁶ are at 10⁻¹⁶.
CPU time, the least of all rounds; bars: quartiles. A curve goes from coarse (top) to fine; dashed: a fixed step."""


def _draw_motion(panels: Sequence[MotionPanel]) -> Figure:
    """Time against error of the motion models and integrators, with u of I_zz as a band; a column a scene."""
    figure = _figure(7.8)
    wide = 0.954 / len(panels)
    for row, tops in enumerate((1, BATCH)):
        times = [part for panel in panels for p in panel.of(tops) for part in (p.seconds, *p.timing.quartiles)]
        limits = (min(times) / 4, max(times) * 2)
        for column, panel in enumerate(panels):
            ax = figure.add_axes((0.072 + wide * column, 0.635 - 0.42 * row, wide - 0.055, 0.295))
            _draw_motion_panel(ax, panel, tops, limits, first=column == 0)
    key = _key_axes(figure, (0.072, 0.0, 0.92, 0.125))
    for i, line in enumerate(_HOW_TO_READ.splitlines()):
        key.text(0.0, 0.95 - 0.19 * i, line, fontsize=8, color=INK, va="top")
    drawn = {point.method for panel in panels for point in panel.points if point.family not in _NAMED}
    for i, method in enumerate(method for method in _LOOKS if method in drawn):
        _draw_method_key(key, 0.02 + 0.2 * (i // 2), 0.38 - 0.22 * (i % 2), method)
    return figure


_NAMED = ("closed form", "exact")
"""Families whose points bear their names."""


def _draw_method_key(ax: Axes, x: float, y: float, method: str, more: str = "") -> None:
    """Explain a line with its marker."""
    colour, marker, line = _LOOKS[method]
    draw_key(ax, [x - 0.02, x, x + 0.02], [y] * 3, method + more, 0.01, marker=marker, markevery=[1], color=colour,
             linestyle=line, linewidth=1.0, markersize=5.5, markeredgecolor="white", markeredgewidth=0.4)  # fmt: skip


def _draw_motion_panel(ax: Axes, panel: MotionPanel, tops: int, limits: tuple[float, float], first: bool) -> None:
    _log_axes(ax, limits, (_FLOOR / 300, 50.0))
    _write_ticks(ax, "x", [time for time in (1e-8, 1e-6, 1e-4, 1e-2, 1.0) if limits[0] < time < limits[1]], time_text)
    _write_ticks(ax, "y", (1e-16, 1e-12, 1e-8, 1e-4, 1.0), _power_text)
    ax.set_xlabel("time for one top, alone" if tops == 1 else f"time for one top, {tops} at once")
    if first:
        ax.set_ylabel("relative error of I_zz")
    ax.axhspan(panel.bound, panel.u, color="#F0E442", alpha=0.55, linewidth=0)
    ax.text(0.995, 1.4 * panel.u, f"u = {percent_text(panel.u)}", transform=ax.get_yaxis_transform(), fontsize=7.5,
            ha="right", va="bottom", color=INK)  # fmt: skip
    own = panel.of(tops)
    for method, (colour, marker, line) in _LOOKS.items():
        points = [point for point in own if point.method == method]
        if points:
            heights = [_error(point) for point in points]
            low, high = zip(*(point.timing.quartiles for point in points), strict=True)
            ax.hlines(heights, low, high, color=colour, linewidth=1.0, alpha=0.7, zorder=6)
            ax.plot([point.seconds for point in points], heights, color=colour, marker=marker, linestyle=line,
                    markersize=5, markeredgecolor="white", markeredgewidth=0.4, linewidth=1.0, zorder=7)  # fmt: skip
    winner = panel.cheapest(tops)
    if winner is not None:
        ax.plot([winner.seconds], [_error(winner)], "o", markersize=12, color="none", markeredgecolor=INK,
                markeredgewidth=1.2, zorder=7)  # fmt: skip
    named = {i: p.method for i, p in enumerate(own) if p.family in _NAMED}
    times, errors = (np.array(values) for values in zip(*((p.seconds, _error(p)) for p in own), strict=True))
    name_dots(ax, times, errors, named)
    name = "none" if winner is None else winner.method
    also = "the ladder takes it too" if name == panel.ladder else f"ladder: {panel.ladder}"
    head(ax, panel.title, f"wins: {name}; {also}")


def _error(point: MotionPoint) -> float:
    return max(point.error, _FLOOR)


# --- motion: orders, and what is kept ------------------------------------------------------------------------


def _draw_orders(orders: Sequence[Order]) -> Figure:
    """Evaluations of the torque against what is lost in one precession: e3 on the left, the energy on the right."""
    figure = _figure(4.6)
    evaluations = [point.evaluations for order in orders for point in order.points]
    limits = min(evaluations) / 1.6, max(evaluations) * 1.6
    for column, (title, note, measure) in enumerate(
        (
            ("distance of e3 from the true one", "numbers: the order, the slope of the curve", "off"),
            ("energy gained or lost, over h m g", "the midpoint rule keeps it, and is late all the same", "energy"),
        )
    ):
        ax = figure.add_axes((0.075 + 0.49 * column, 0.245, 0.42, 0.625))
        _log_axes(ax, limits, (3 * _FLOOR, 3.0))
        _write_ticks(ax, "x", [10.0**power for power in range(1, 8) if limits[0] < 10**power < limits[1]], _count_text)
        _write_ticks(ax, "y", (1e-16, 1e-12, 1e-8, 1e-4, 1.0), _power_text)
        ax.grid(color="#eeeeee", linewidth=0.6)
        ax.set_xlabel("evaluations of the torque in one precession")
        ends: list[tuple[float, float]] = []
        names: dict[int, str] = {}
        for order in orders:
            colour, marker, line = _LOOKS[order.method]
            xs = [point.evaluations for point in order.points]
            ys = [max(getattr(point, measure), _FLOOR) for point in order.points]
            ax.plot(xs, ys, color=colour, marker=marker, linestyle=line, markersize=4.5, markeredgecolor="white",
                    markeredgewidth=0.4, linewidth=1.0)  # fmt: skip
            if measure == "off" and order.order is not None:
                names[len(ends)] = f"{order.order:.1f}"
            ends.append((xs[-1], ys[-1]))
        if names:
            x, y = np.array(ends).T
            name_dots(ax, x, y, names)
        head(ax, title, note)
    key = _key_axes(figure, (0.075, 0.0, 0.905, 0.125))
    for i, order in enumerate(orders):
        slope = "" if order.order is None else f": {order.order:.1f}"
        _draw_method_key(key, 0.025 + 0.212 * (i // 2), 0.7 - 0.42 * (i % 2), order.method, slope)
    return figure


def _count_text(value: float) -> str:
    return f"{value:,.0f}".replace(",", "\u202f")


def _draw_drift(drifts: Sequence[Drift]) -> Figure:
    """What each integrator has lost after so many precessions: energy, the length of e3, and where it points."""
    figure = _figure(3.9)
    for column, (title, note, measure) in enumerate(
        (
            ("energy, over h m g", "splitting and midpoint: no drift", "energy"),
            ("length: | |e3| − 1 |", "RK4 and DOP853 leave the sphere", "length"),
            ("distance of e3 from the true one", "with the energy the phase goes astray", "off"),
        )
    ):
        ax = figure.add_axes((0.072 + 0.323 * column, 0.29, 0.262, 0.555))
        last = float(drifts[0].precessions[-1])
        least = min(float(getattr(drift, measure).min()) for drift in drifts)
        low = max(_FLOOR, least) / 5
        _log_axes(ax, (float(drifts[0].precessions[0]) / 1.3, last * 1.3), (low, 10.0))
        _write_ticks(ax, "x", [ten for ten in (0.1, 1.0, 10.0, 100.0, 1000.0) if ten <= last * 1.3], lambda v: f"{v:g}")
        powers = range(0, -17, -4 if low < 1e-8 else -1)
        _write_ticks(ax, "y", [10.0**power for power in powers if 10.0**power > low], _power_text)
        ax.grid(color="#eeeeee", linewidth=0.6)
        ax.set_xlabel("precessions")
        for drift in drifts:
            colour, marker, line = _LOOKS[drift.method]
            # Strang and ABA84 share a colour: their markers tell them apart.
            ax.plot(drift.precessions, np.maximum(getattr(drift, measure), _FLOOR), color=colour, marker=marker,
                    linestyle=line, markersize=4.5, markeredgecolor="white", markeredgewidth=0.4, linewidth=1.0,
                    markevery=(drifts.index(drift), 6))  # fmt: skip
        head(ax, title, note)
    key = _key_axes(figure, (0.072, 0.0, 0.915, 0.15))
    for i, drift in enumerate(drifts):
        x, y = 0.025 + 0.34 * (i // 2), 0.72 - 0.42 * (i % 2)
        _draw_method_key(key, x, y, drift.method)
        words = f"{drift.setting}: {drift.per_nutation:.0f} evaluations"
        key.text(x + 0.03, y - 0.2, words, fontsize=7, color=SOFT, va="center")
    return figure


# --- estimators: time against error -------------------------------------------------------------------------

_SHADES = (
    (HONEST[1], "#56B4E9", "D", "98 % and more: too wide"),
    (HONEST[0], "#0072B2", "o", "92 to 98 %: honest"),
    (0.8, "#CC79A7", "s", "80 to 92 %"),
    (0.5, "#E69F00", "^", "50 to 80 %"),
    (-1.0, "#D55E00", "v", "less than 50 %"),
)
"""Least coverage, colour, marker and words, from Okabe and Ito's set: dark blue is honest."""

_TWINS = ("P on M, origin", "P on M, constant", "ODR, origin", "ODR, constant")
"""They lie upon those of M on P, and upon York's."""

_TIMES = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0)


def _look(trial: Trial) -> tuple[str, str]:
    """Colour and marker."""
    if trial.honest:
        return _SHADES[1][1:3]
    return next(shade[1:3] for shade in _SHADES if trial.coverage >= shade[0] and shade[3] != _SHADES[1][3])


def _shade_key(key: Axes, height: float) -> None:
    key.text(0.0, height, "the 95 % interval holds the truth in", fontsize=8, color=INK, va="center")
    for (_, colour, marker, text), x in zip(_SHADES, (0.265, 0.46, 0.62, 0.735, 0.855), strict=True):
        draw_key(key, [x], [height], text, 0.012, marker=marker, color=colour, markersize=6,
                 markeredgecolor="white", markeredgewidth=0.5)  # fmt: skip


def _draw_trials(panels: Sequence[TrialPanel]) -> Figure:
    """Time for a fit against RMSE of I_zz in four kinds of lab, coverage as colour, with the Cramér–Rao bound."""
    shown = [panel for panel in panels if panel.scene.name in CHARTED]
    figure = _figure(7.6)
    times = [trial.time.seconds for panel in shown for trial in panel.trials if trial.time]
    limits = min(times) / 2.5, max(times) * 2.5
    for i, panel in enumerate(shown):
        row, column = divmod(i, 2)
        ax = figure.add_axes((0.085 + 0.49 * column, 0.605 - 0.455 * row, 0.415, 0.325))
        _draw_trial_panel(ax, panel, limits, first=column == 0, last=row == 1)
    key = _key_axes(figure, (0.03, 0.008, 0.965, 0.085))
    _shade_key(key, 0.85)
    notes = (
        "M: torque; P = φ̇ψ̇; P on M lies on M on P, ODR on York. CPU time for one log: least of several rounds, and "
        "quartiles; error: ± 2 standard errors\n"
        "dashed: the Cramér–Rao bound, which the best possible fit reaches where nobody knows M0; dotted: where M0 is "
        "known"
    ).splitlines()
    for i, note in enumerate(notes):
        key.text(0.0, 0.5 - 0.3 * i, note, fontsize=7.5, color=SOFT, va="center")
    return figure


def _draw_bounds(ax: Axes, bounds: Sequence[float], horizontal: bool) -> None:
    """Draw the Cramér–Rao bounds, M0 unknown and known."""
    for bound, style in zip(bounds, ((0, (5, 2)), (0, (1, 2))), strict=True):
        line = ax.axhline if horizontal else ax.axvline
        line(bound, color=INK, linewidth=0.9, linestyle=style, zorder=2)


def _draw_trial_panel(ax: Axes, panel: TrialPanel, times: tuple[float, float], first: bool, last: bool) -> None:
    trials = [(trial, trial.time) for trial in panel.trials if trial.time and trial.estimator not in _TWINS]
    errors = np.array([trial.rmse for trial, _ in trials])
    limits = min(float(errors.min()), panel.bound_balanced) / 1.35, float(errors.max()) * 1.6
    _log_axes(ax, times, limits)
    _write_ticks(ax, "x", [time for time in _TIMES if times[0] < time < times[1] / 1.3], time_text)
    _write_ticks(ax, "y", log_ticks(*limits), percent_text)
    ax.grid(axis="y", color="#e4e4e4", linewidth=0.6)
    if last:
        ax.set_xlabel("CPU time for one fit")
    if first:
        ax.set_ylabel("RMSE of I_zz")
    _draw_bounds(ax, (panel.bound, panel.bound_balanced), horizontal=True)
    for trial, time in trials:
        colour, marker = _look(trial)
        mine = trial is panel.recommended
        spread = 2 * trial.rmse_u
        ax.plot([time.seconds, time.quartiles[1]], [trial.rmse] * 2, color=colour, linewidth=0.8, zorder=3)
        ax.plot([time.quartiles[0]], [trial.rmse], marker="|", color=colour, markersize=4, zorder=3)
        ax.plot([time.seconds] * 2, [max(trial.rmse - spread, limits[0]), trial.rmse + spread], color=colour,
                linewidth=0.8, zorder=3)  # fmt: skip
        ax.plot(
            [time.seconds], [trial.rmse], marker=marker, color=colour, markersize=9 if mine else 6,
            markeredgecolor=INK if mine else "white", markeredgewidth=1.2 if mine else 0.5, zorder=7,
        )  # fmt: skip
    names = {i: trial.estimator for i, (trial, _) in enumerate(trials)}
    seconds = np.array([time.seconds for _, time in trials])
    bold = [i for i, (trial, _) in enumerate(trials) if trial is panel.recommended]
    name_dots(ax, seconds, errors, names, bold=bold)
    head(ax, f"{panel.scene.title}: {panel.outcome}", f"{panel.scene.words}; {panel.labs} labs")


# --- estimators: all scenes -----------------------------------------------------------------------------------

_ACROSS, _WIDEST = 7, 12.0
"""Scenes side by side; errors beyond so many times the bound stand at the edge."""


def _draw_scenes(panels: Sequence[TrialPanel]) -> Figure:
    """RMSE of every estimator over the Cramér–Rao bound, a column a scene, coverage as colour."""
    names = [trial.estimator for trial in panels[0].trials]
    rows = -(-len(panels) // _ACROSS)
    tall = 0.17 * (len(names) + 1)
    height = 0.68 + rows * (tall + 1.0)
    figure = _figure(height)
    # Those that take M0 = 0 stand apart from those that do not.
    at = {name: i + (0 if name in TAKE_BALANCE else 0.9) for i, name in enumerate(names)}
    for i, panel in enumerate(panels):
        row, column = divmod(i, _ACROSS)
        bottom = (height - (row + 1) * (tall + 1.0) + 0.34) / height
        ax = figure.add_axes((0.148 + 0.122 * column, bottom, 0.108, tall / height))
        _draw_scene(ax, panel, at)
        if not column:
            ax.yaxis.set_ticks([at[name] for name in names], names)
            ax.get_yticklabels()[-1].set_fontweight("bold")
            for words, place in (("take M0 = 0", 4.5), ("M0 left open", 14.4)):
                ax.text(-1.27, place, words, transform=ax.get_yaxis_transform(), rotation=90, fontsize=8, color=SOFT,
                        ha="center", va="center")  # fmt: skip
    key = _key_axes(figure, (0.012, 0.0, 0.985, 0.66 / height))
    _shade_key(key, 0.8)
    notes = (
        "RMSE of I_zz over its Cramér–Rao bound where nobody knows M0 (dashed; in % below the title; dotted: M0 "
        "known); bars: ± 2 standard errors\n"
        f"{panels[0].labs} labs a scene; arrow: farther off; third line: the tool's own fit beside the honest others, "
        f"which tie within {100 * (TIE - 1):.0f} %"
    ).splitlines()
    for i, note in enumerate(notes):
        key.text(0.0, 0.47 - 0.27 * i, note, fontsize=7.5, color=SOFT, va="center")
    return figure


def _draw_scene(ax: Axes, panel: TrialPanel, at: Mapping[str, float]) -> None:
    ax.set_xscale("log")
    ax.set_xlim(0.25, _WIDEST * 1.35)
    ax.set_ylim(max(at.values()) + 0.7, -0.7)
    _write_ticks(ax, "x", (0.5, 1, 2, 5, 10), lambda value: f"{value:g}")
    ax.yaxis.set_ticks([])
    ax.tick_params(labelsize=7.5, length=2)
    for place in at.values():
        ax.axhline(place, color="#ececec", linewidth=0.6, zorder=0)
    _draw_bounds(ax, (1.0, panel.bound_balanced / panel.bound), horizontal=False)
    for trial in panel.trials:
        colour, marker = _look(trial)
        mine = trial is panel.recommended
        ratio, spread = trial.rmse / panel.bound, 2 * trial.rmse_u / panel.bound
        far = ratio > _WIDEST
        ax.plot([max(ratio - spread, 0.26), min(ratio + spread, _WIDEST)] if not far else [_WIDEST / 1.5, _WIDEST],
                [at[trial.estimator]] * 2, color=colour, linewidth=0.9, zorder=3)  # fmt: skip
        ax.plot(
            [min(ratio, _WIDEST)], [at[trial.estimator]], marker=">" if far else marker, color=colour,
            markersize=7 if mine else 5, markeredgecolor=INK if mine else "white", markeredgewidth=1.1 if mine else 0.4,
            zorder=7, clip_on=False,
        )  # fmt: skip
    tall = 72 * ax.bbox.height / ax.figure.dpi
    lines = (
        (panel.scene.title, 32, 8.5, INK, "bold"),
        (f"bound {percent_text(panel.bound)}", 22, 7.5, SOFT, "normal"),
        *zip(_in_two(panel.outcome), (13, 4), (7, 7), (INK, INK), ("normal", "normal"), strict=True),
    )
    for text, up, size, colour, weight in lines:
        ax.text(0.0, 1 + up / tall, text, transform=ax.transAxes, fontsize=size, color=colour, weight=weight)


def _in_two(text: str) -> tuple[str, str]:
    """Break a text in two lines, the first as long as 18 letters allow."""
    words, first = text.split(" "), ""
    while words and len(first) + len(words[0]) <= 18:
        first = f"{first} {words.pop(0)}".strip()
    return first, " ".join(words)


# --- stability: fits while labs become worse ------------------------------------------------------------------

_FITS = {
    "M on P, constant": ("#D55E00", "v"),
    "ODR, constant": ("#000000", "v"),
    "York, constant": ("#E69F00", "^"),
    "full cov., origin": ("#CC79A7", "D"),
    "pretest": ("#777777", "X"),
    "full cov., constant": ("#56B4E9", "s"),
    "full cov., iterated": ("#009E73", "P"),
    "median of ratios": ("#009E73", "D"),
    "Huber": ("#000000", "X"),
    "recommended": ("#0072B2", "o"),
}
"""Colour and marker of each fit."""


def _draw_fit_curves(curves: Sequence[FitCurve]) -> Figure:
    """Coverage, and RMSE over the Cramér–Rao bound, of fits while one thing after another becomes worse."""
    figure = _figure(8.3)
    for i, curve in enumerate(curves):
        row, column = divmod(i, 3)
        left, bottom = 0.075 + 0.318 * column, 0.595 - 0.455 * row
        upper = figure.add_axes((left, bottom + 0.185, 0.265, 0.165))
        lower = figure.add_axes((left, bottom, 0.265, 0.165))
        _draw_fit_curve(upper, lower, curve, first=column == 0)
    key = _key_axes(figure, (0.03, 0.012, 0.965, 0.085))
    for i, (name, (colour, marker)) in enumerate(_FITS.items()):
        column, row = divmod(i, 2)
        draw_key(key, [0.01 + 0.17 * column], [0.85 - 0.3 * row], name, 0.015, marker=marker, color=colour,
                 markersize=5.5, markeredgecolor="white", markeredgewidth=0.4)  # fmt: skip
    draw_key(key, [0.86], [0.85], "fails first here", 0.015, marker="o", color="none", markeredgecolor=INK,
             markersize=10, markeredgewidth=1.1)  # fmt: skip
    draw_key(key, [0.86, 0.86], [0.62, 0.46], "± 1 standard error", 0.015, color=SOFT, linewidth=0.9)
    key.text(
        0.0, 0.22,
        "fails: the interval holds the truth in less than 92 % (yellow: 92 to 98 %), or the error is over twice the "
        "Cramér–Rao bound (dotted), by more than",
        fontsize=7.5, color=SOFT, va="center",
    )  # fmt: skip
    key.text(0.0, 0.0, "2 standard errors; errors beyond 12 times the bound stand at the edge", fontsize=7.5,
             color=SOFT, va="center")  # fmt: skip
    return figure


def _draw_fit_curve(upper: Axes, lower: Axes, curve: FitCurve, first: bool) -> None:
    xs = np.array([point.x for point in curve.points])
    even = xs.min() <= 0
    # Where 0 is among them steps are even; their values are written.
    places = np.arange(len(xs), dtype=float) if even else xs
    for ax in (upper, lower):
        if even:
            ax.set_xlim(-0.4, len(xs) - 0.6)
            ax.xaxis.set_ticks(places, [f"{x:g}" for x in xs])
        else:
            ax.set_xscale("log")
            ax.set_xlim(xs.min() / 1.15, xs.max() * 1.15)
            _write_ticks(ax, "x", _few(xs), lambda value: f"{value:g}")
        ax.tick_params(labelsize=8, length=3)
        ax.grid(axis="y", color="#e4e4e4", linewidth=0.6)
    upper.tick_params(labelbottom=False)
    upper.set_ylim(-4, 104)
    upper.yaxis.set_ticks([0, 50, 80, 95])
    upper.axhspan(100 * HONEST[0], 100 * HONEST[1], color="#F0E442", alpha=0.5, linewidth=0)
    lower.set_yscale("log")
    lower.set_ylim(0.4, 15)
    _write_ticks(lower, "y", (0.5, 1, 2, 5, 10), lambda value: f"{value:g}")
    _draw_bounds(lower, (1.0, 2.0), horizontal=True)
    lower.set_xlabel(curve.x_label, fontsize=8.5)
    if first:
        upper.set_ylabel("truth in 95 %\ninterval [%]", fontsize=8.5)
        lower.set_ylabel("RMSE over bound", fontsize=8.5)
    for name in curve.estimators:
        colour, marker = _FITS[name]
        trials = [point.of(name) for point in curve.points]
        errors = np.array([trial.rmse / point.bound for trial, point in zip(trials, curve.points, strict=True)])
        error_u = np.array([trial.rmse_u / point.bound for trial, point in zip(trials, curve.points, strict=True)])
        covers = np.array([100 * trial.coverage for trial in trials])
        covers_u = np.array([100 * math.sqrt(t.coverage * (1 - t.coverage) / t.labs) for t in trials])
        wide, front = (1.8, 6) if name == "recommended" else (1.0, 4)
        near = errors < _WIDEST
        shown = (upper, covers, covers_u), (lower, np.minimum(errors, _WIDEST), np.where(near, error_u, 0.0))
        for ax, values, u in shown:
            ax.vlines(places, values - u, values + u, color=colour, linewidth=0.8, zorder=front)
            ax.plot(places, values, color=colour, marker=marker, markersize=4.5, markeredgecolor="white",
                    markeredgewidth=0.4, linewidth=wide, zorder=front, clip_on=False)  # fmt: skip
            begun = curve.first_failure(name)
            if begun is not None:
                i = int(np.flatnonzero(xs == begun)[0])
                ax.plot([places[i]], [values[i]], "o", color="none", markeredgecolor=INK, markersize=10,
                        markeredgewidth=1.1, zorder=8, clip_on=False)  # fmt: skip
    counts = sorted({point.labs for point in curve.points})
    labs = f"{counts[-1]} labs" if len(counts) == 1 else f"{counts[0]} to {counts[-1]} labs"
    head(upper, curve.title, f"{curve.words}; {labs}")


def _few(values: Floats) -> list[float]:
    """Leave out values that are too near to the one before to be written on a logarithmic axis."""
    kept = [float(values[0])]
    for value in values[1:]:
        if value / kept[-1] > (values[-1] / values[0]) ** 0.11:
            kept.append(float(value))
    return kept


# --- stability: formulas as the rod becomes level or upright --------------------------------------------------

_FORMULAS = ("#D55E00", "#E69F00", "#0072B2", "#009E73")


def _draw_cosines(curves: Sequence[DigitCurve]) -> Figure:
    """Correct digits of formulas for the rate of steady precession as cosθ → 0 and as cosθ → 1."""
    figure = _figure(3.7)
    looks = dict(zip(dict.fromkeys(curve.method for curve in curves), zip(_FORMULAS, "v^os", strict=True), strict=True))
    heads = {
        "level": ("rod nearly level, cosθ → 0", "the textbook root is a difference of nearly equal numbers", "cosθ"),
        "vertical": (
            "rod nearly upright, cosθ → 1", "worst at the least spin that lets it precess steadily, where D → 0",
            "1 − cosθ",
        ),
    }  # fmt: skip
    for i, (end, (title, words, label)) in enumerate(heads.items()):
        ax = figure.add_axes((0.065 + 0.485 * i, 0.285, 0.43, 0.605))
        ax.set_xscale("log")
        shown = [curve for curve in curves if curve.end == end]
        away = shown[0].away
        ax.set_xlim(float(away.max()) * 2, float(away[away > 0].min()) / 2)
        ax.set_ylim(-0.6, 17)
        ax.yaxis.set_ticks([0, 4, 8, 12, 16])
        _write_ticks(ax, "x", [10.0**power for power in range(-16, 1, 4)], _power_text)
        ax.grid(axis="y", color="#e4e4e4", linewidth=0.6)
        ax.set_xlabel(label)
        if not i:
            ax.set_ylabel("correct digits of the rate")
        for curve in shown:
            colour, marker = looks[curve.method]
            ax.plot(away, curve.middle, color=colour, linewidth=1.6)
            ax.plot(away, curve.worst, color=colour, linewidth=0.9, linestyle=(0, (3, 1.5)), marker=marker,
                    markevery=(len(away) // 12, max(len(away) // 6, 1)), markersize=5, markeredgecolor="white",
                    markeredgewidth=0.4)  # fmt: skip
        head(ax, title, words)
    key = _key_axes(figure, (0.065, 0.0, 0.92, 0.13))
    for i, (method, (colour, marker)) in enumerate(looks.items()):
        draw_key(key, [0.015 + 0.24 * i], [0.7], method, 0.015, marker=marker, color=colour, markersize=5.5)
    key.text(
        0.0, 0.2,
        "solid: median over 24 spins of 60 to 1000 rpm, and the least with which an upright rod precesses steadily; "
        "dashed: the worst; 2c/(b + √D) is in the tool",
        fontsize=7.5, color=SOFT, va="center",
    )  # fmt: skip
    return figure


# --- stability: maps of correct digits ----------------------------------------------------------------------


def _draw_maps(pairs: Sequence[MapPair]) -> Figure:
    """Maps of correct digits, a row a pair: what fails on the left, what holds on the right."""
    height = 0.35 + 2.65 * len(pairs)
    figure = _figure(height)
    shown: Any = None
    for row, pair in enumerate(pairs):
        bottom = (height - 2.65 * (row + 1) + 0.4) / height
        for column, (one, says) in enumerate(((pair.fails, "fails"), (pair.holds, "holds"))):
            ax = figure.add_axes((0.078 + 0.435 * column, bottom, 0.36, 1.85 / height))
            shown = _draw_map(ax, pair, one, first=column == 0, last=row == len(pairs) - 1)
            cost = "" if one.evaluations is None else f"; {_count_text(one.evaluations)} evaluations"
            head(ax, f"{says}: {one.method}", pair.title + cost)
    bar = figure.add_axes((0.905, 0.4 / height, 0.016, (height - 1.2) / height))
    figure.colorbar(shown, cax=bar, ticks=[0, 4, 8, 12, 16])
    bar.set_ylabel("correct digits", fontsize=9)
    bar.tick_params(length=3)
    return figure


def _draw_roots(pairs: Sequence[MapPair]) -> Figure:
    """Correct digits of formulas over tilt and over cosθ: median and worst of all spins, one panel a pair."""
    figure = _figure(3.9)
    for column, pair in enumerate(pairs):
        ax = figure.add_axes((0.065 + 0.49 * column, 0.285, 0.42, 0.56))
        ax.set_xlim(float(pair.y.min()), float(pair.y.max()))
        ax.set_ylim(-0.4, MOST_DIGITS + 0.6)
        ax.yaxis.set_ticks([0, 4, 8, 12, 16])
        ax.grid(color="#eeeeee", linewidth=0.6)
        ax.set_xlabel(pair.y_label)
        if column == 0:
            ax.set_ylabel("correct digits")
        empty = np.isnan(pair.holds.digits).mean(axis=1)
        if pair.empty and empty.max() > 0.2:
            ax.fill_between(pair.y, 0, MOST_DIGITS * empty, color="#dddddd", linewidth=0, zorder=0)
            words = f"{pair.empty}\nat up to {percent_text(float(empty.max()))} of the spins"
            above = MOST_DIGITS * float(empty.max()) + 0.3
            ax.text(0.99, above, words, transform=ax.get_yaxis_transform(), fontsize=7.5, color=SOFT, ha="right")
        key = _key_axes(figure, (0.065 + 0.49 * column, 0.0, 0.42, 0.13))
        for row, (one, says, (colour, marker)) in enumerate(
            ((pair.fails, "fails", ("#D55E00", "v")), (pair.holds, "holds", ("#0072B2", "o")))
        ):
            told = ~np.isnan(one.digits).all(axis=1)
            dots: Any = {"marker": marker, "color": colour, "markeredgecolor": "white", "markeredgewidth": 0.4}
            every = max(1, len(pair.y) // 12)
            for summary, line in ((np.nanmedian, "-"), (np.nanmin, ":")):
                ax.plot(pair.y[told], summary(one.digits[told], axis=1), linestyle=line, linewidth=1.3, markersize=4,
                        markevery=every, **dots)  # fmt: skip
            height = [0.75 - 0.45 * row] * 3
            draw_key(
                key, [0.01, 0.035, 0.06], height, f"{says}: {one.method}", 0.02, markevery=[1], markersize=5, **dots
            )
        head(ax, pair.title, "over all spins from 20 to 1000 rpm: median (line), worst (dotted)")
    return figure


def _draw_map(ax: Axes, pair: MapPair, one: DigitMap, first: bool, last: bool) -> Any:
    ax.set_facecolor("#bbbbbb")
    # Rasterised: an SVG of thousands of squares is slow to show.
    mesh = ax.pcolormesh(pair.x, pair.y, np.ma.masked_invalid(one.digits), cmap="cividis", vmin=0, vmax=MOST_DIGITS,
                         shading="nearest", rasterized=True)  # fmt: skip
    ax.set_xscale("log")
    _write_ticks(ax, "x", log_ticks(float(pair.x[0]), float(pair.x[-1])), lambda tick: f"{tick:g}")
    if last:
        ax.set_xlabel(pair.x_label)
    if first:
        ax.set_ylabel(pair.y_label)
    return mesh


# --- stability: near the vertical ---------------------------------------------------------------------------

_COLOURS = dict(zip(METHODS, ("#D55E00", "#CC79A7", "#0072B2", "#E69F00", "#009E73"), strict=True))
_MARKERS = dict(zip(METHODS, "vso>P", strict=True))


def _draw_upright(passages: Sequence[Passage]) -> Figure:
    """What orbits that pass near the vertical cost, and how wrong they come out."""
    figure = _figure(3.7)
    left = figure.add_axes((0.075, 0.15, 0.29, 0.68))
    right = figure.add_axes((0.555, 0.15, 0.29, 0.68))
    started = "; ".join(one.method for one in passages if one.closest == 0 and one.error is None) or "none"
    _draw_lines(left, [(one.method, one.closest, one.error) for one in passages if one.closest])
    head(left, "error of the rod's direction in 10 s", f"started at the vertical, no answer: {started}")
    _draw_lines(right, [(one.method, one.closest, one.evaluations) for one in passages if one.closest])
    head(right, "evaluations for 10 s", "of the right-hand side by DOP853, rtol 1e-9; of the torque in splitting")
    return figure


def _draw_lines(ax: Axes, values: Sequence[tuple[str, float, float | None]]) -> None:
    told = [(method, x, y) for method, x, y in values if y is not None]
    xs, ys = [x for _, x, _ in told], [y for _, _, y in told]
    _log_axes(ax, (max(xs) * 3, min(xs) / 3), (min(ys) / 6, max(ys) * 6))
    ends = {}
    for method, colour in _COLOURS.items():
        points = [(x, y) for name, x, y in told if name == method]
        if points:
            ax.plot(*zip(*points, strict=True), color=colour, marker=_MARKERS[method], markersize=5, linewidth=1.2)
            ends[method] = points[-1]
    heights = [float(y) for y in ax.transAxes.inverted().transform(ax.transData.transform(list(ends.values())))[:, 1]]
    for method, end, height in zip(ends, heights, spread(heights, 0.065), strict=True):
        draw_key(ax, [1.0, 1.035], [end, height], method, 0.01, color=_COLOURS[method], linewidth=0.8, clip_on=False)
    powers = [10.0**power for power in range(-16, 7)]
    _write_ticks(ax, "x", [p for p in powers if min(xs) * 0.9 <= p <= max(xs)][::2], _power_text)
    _write_ticks(ax, "y", [p for p in powers if min(ys) / 3 <= p <= max(ys) * 3], _power_text)
    ax.set_xlabel("smallest angle from the vertical [rad]")


# --- stability: logs that break fits ------------------------------------------------------------------------

_VERDICTS: dict[Verdict, tuple[str, str, str]] = {
    "holds": ("#0072B2", "white", "holds"),
    "wide": ("#F0E442", INK, "holds, but ± over 50 %"),
    "says so": ("#eeeeee", INK, "no answer, and says so"),
    "too sure": ("#E69F00", INK, "interval too small"),
    "nonsense": ("#D55E00", "white", "nonsense, silently"),
}
"""Ground, ink and words of each verdict."""


def _draw_breakdowns(breakdowns: Sequence[Breakdown]) -> Figure:
    """What each estimator makes of each kind of broken log; in each cell the median error of I_zz and the coverage."""
    cases = list(dict.fromkeys(one.case for one in breakdowns))
    estimators = list(dict.fromkeys(one.estimator for one in breakdowns))
    height = 1.05 + 0.29 * len(estimators)
    figure = _figure(height)
    ax = figure.add_axes((0.16, 0.42 / height, 0.83, 0.29 * len(estimators) / height))
    ax.set_xlim(0, len(cases))
    ax.set_ylim(len(estimators), 0)
    for one in breakdowns:
        _draw_cell(ax, cases.index(one.case), estimators.index(one.estimator), one)
    ax.xaxis.set_ticks([i + 0.5 for i in range(len(cases))], [_folded(case) for case in cases])
    ax.xaxis.tick_top()
    ax.yaxis.set_ticks([i + 0.5 for i in range(len(estimators))], estimators)
    ax.text(
        -0.02,
        -0.55,
        f"median error of I_zz\n(truth inside, of {breakdowns[0].draws} logs)",
        fontsize=7.5,
        color=SOFT,
        ha="right",
        va="center",
    )
    ax.tick_params(length=0, labelsize=8)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    key = _key_axes(figure, (0.16, 0.0, 0.83, 0.36 / height))
    x = 0.009
    for ground, _, words in _VERDICTS.values():
        draw_key(key, [x], [0.5], words, 0.015, marker="s", markersize=10, markerfacecolor=ground,
                 markeredgecolor=SOFT, markeredgewidth=0.4)  # fmt: skip
        x += 0.045 + 0.0085 * len(words)
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
    text = "–"
    if one.error is not None and one.verdict != "says so":
        text = percent_text(one.error) if one.error <= 9.995 else "over × 10"
    if one.verdict != "says so":
        text += f"  ({round(one.coverage * one.draws)})"
    ax.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=8, color=ink)


_DRAWERS: dict[str, Callable[[Benchmark], Figure]] = {
    "motion": lambda benchmark: _draw_motion(benchmark.motion[:3]),
    "motion_harder": lambda benchmark: _draw_motion(benchmark.motion[3:]),
    "motion_order": lambda benchmark: _draw_orders(benchmark.orders),
    "motion_drift": lambda benchmark: _draw_drift(benchmark.drifts),
    "estimators": lambda benchmark: _draw_trials(benchmark.trials),
    "estimators_scenes": lambda benchmark: _draw_scenes(benchmark.trials),
    "stability_steady": lambda benchmark: _draw_roots(benchmark.roots),
    "stability_integrators": lambda benchmark: _draw_maps(benchmark.integrators),
    "stability_upright": lambda benchmark: _draw_upright(benchmark.passages),
    "stability_estimators": lambda benchmark: _draw_breakdowns(benchmark.breakdowns),
    "stability_fits": lambda benchmark: _draw_fit_curves(benchmark.curves),
    "stability_cosine": lambda benchmark: _draw_cosines(benchmark.cosines),
}
"""By the name of the file, what draws it."""
