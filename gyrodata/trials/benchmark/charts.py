"""The four charts of `gyro benchmark`: motion, integrators, fits, and where methods fail."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrodata.reporting import figures
from gyrodata.trials.benchmark import (
    HONEST,
    METHODS,
    Benchmark,
    Failure,
    MotionPanel,
    Order,
    TrialPanel,
    cheapest,
    power,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, RED, PURPLE, GREY = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#CC79A7",
    "#666666",
)
"""Okabe and Ito's colours, which colour-blind readers can distinguish."""

BAND: Any = {"color": "#F0E442", "alpha": 0.45, "linewidth": 0, "zorder": 0}

STYLES = figures.STYLE, Path(__file__).with_suffix(".mplstyle")


def render_benchmark(benchmark: Benchmark) -> dict[str, bytes]:
    """Draw all charts, 9 inches wide.

    Return the bytes of each file by its name, the same for the same benchmark.
    """
    files: dict[str, bytes] = {}
    with figures.own_style(*STYLES):
        drawn = {
            "motion": _draw_motion(benchmark.motion),
            "motion_order": _draw_orders(benchmark.orders),
            "estimators": _draw_trials(benchmark.trials),
            "failures": _draw_failures(benchmark.failures),
        }
        for name, figure in drawn.items():
            figure.supxlabel(
                benchmark.machine, x=0.01, ha="left", fontsize=6.5, color=GREY
            )
            files[f"{name}.png"] = figures.save(figure, "png", 9)
            files[f"{name}.svg"] = figures.save(figure, "svg")
    return files


def _figure(height: float, title: str) -> Figure:
    """Create a figure with a title."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, height), dpi=120, layout="constrained")
    figure.suptitle(title, x=0.01, ha="left")
    return figure


# --- motion ---

_MODELS = {
    "eq. (9)": (BLUE, "o"),
    "eq. (8)": (RED, "s"),
    "mean rate of a release": (PURPLE, "D"),
    "full motion": ("black", "."),
}
"""Colour and marker of each model."""


def _draw_motion(panels: Sequence[MotionPanel]) -> Figure:
    """Draw the cost of each model against its error in units of u, a panel for each kind of lab."""
    figure = _figure(
        6.8, "Models of the motion: the cheapest one below the band wins\n"
    )
    words = (
        "rods up to 2° from their tilt, pushed by hand (not at the lower left), with "
        "drag and the Earth's rotation"
    )
    figure.text(0.01, 0.948, words, va="center")
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for ax, panel in zip(grid.flat, panels, strict=True):
        ax.set(xscale="log", yscale="log", xlim=(4e-7, 1))
        ax.set(
            xlabel="CPU time for nine runs, in Python [s]",
            ylabel="error of I_zz over its u",
        )
        ax.axhspan(panel.bound / panel.u, 1, **BAND)
        for method, (colour, marker) in _MODELS.items():
            points = [point for point in panel.points if point.method == method]
            x = [point.seconds for point in points]
            y = [point.error / panel.u for point in points]
            ax.plot(
                x,
                y,
                color=colour,
                marker=marker,
                label=method,
                linewidth=len(points) > 1,
            )
        won = (panel.winner.seconds, panel.winner.error / panel.u)
        ax.plot(*won, "o", markersize=13, fillstyle="none", color="black")
        ax.annotate(
            "wins", won, (-9, 0), textcoords="offset points", ha="right", va="center"
        )
        words = f"0.3 u to u = {100 * panel.u:.1f} %"
        ax.text(
            0.99,
            0.5,
            words,
            transform=ax.get_yaxis_transform(),
            ha="right",
            va="center",
        )
        ax.set_title(panel.scene.heading)
        ax.label_outer()
    grid[0, 0].legend(loc="lower left")
    return figure


# --- integrators ---

_CURVES = dict(
    zip(
        METHODS,
        ((ORANGE, "<"), (GREEN, ">"), (RED, "v"), (BLUE, "X"), ("black", "o")),
        strict=True,
    )
)


def _draw_orders(orders: Sequence[Order]) -> Figure:
    """Draw the error of e3 against the number of evaluations.

    The error is drawn after one turn and after many turns.
    """
    figure = _figure(
        5.2,
        "Integrators: splitting is the cheapest for low accuracy, a high order for high accuracy",
    )
    one, many = figure.subplots(1, 2, sharey=True)
    for ax, turns in zip(
        (one, many), dict.fromkeys(order.turns for order in orders), strict=True
    ):
        ax.set(xscale="log", yscale="log", xlabel="evaluations of the torque")
        for order in orders:
            if order.turns == turns:
                colour, marker = _CURVES[order.method]
                x = [point.evaluations for point in order.points]
                y = [point.off for point in order.points]
                label = f"{order.method}, order {order.order or 0:.1f}"
                ax.plot(
                    x,
                    y,
                    color=colour,
                    marker=marker,
                    markersize=4,
                    linewidth=1.2,
                    label=label,
                )
        best = cheapest(orders, turns).items()
        wins = [
            f"{name} from {power(most)} to {power(least)}"
            for name, (most, least) in best
        ]
        ax.set_title(f"{turns} turn{'s' * (turns > 1)} about the vertical")
        ax.text(
            0.99,
            0.99,
            "\n".join(["fewest evaluations:", *wins]),
            transform=ax.transAxes,
            ha="right",
            va="top",
            fontsize=8,
        )
    one.set(ylabel="error of the direction e3", ylim=(1e-13, 1e3))
    many.legend(
        *one.get_legend_handles_labels(),
        loc="lower left",
        title="order: slope of the left curve",
    )
    for slope, ratio in ((2, 25.0), (4, 20.0), (8, 6.0)):
        end = 2000 * ratio, ratio**-slope
        one.plot([2000, end[0]], [1, end[1]], color=GREY, linestyle=":", linewidth=1)
        one.annotate(
            f"order {slope}",
            end,
            (3, -3),
            textcoords="offset points",
            color=GREY,
            fontsize=8,
        )
    return figure


# --- fits ---


def _draw_trials(panels: Sequence[TrialPanel]) -> Figure:
    """Draw bias, error, coverage and cost of each fit.

    They are drawn for correct and for incorrect stated uncertainties.
    """
    figure = _figure(
        4.4,
        "Fits: only the recommended one is honest for correct and incorrect uncertainties\n",
    )
    names = [trial.estimator for trial in panels[0].trials]
    bias, rmse, coverage, cost = figure.subplots(1, 4, sharey=True)
    for shift, panel, colour, marker in zip(
        (-0.2, 0.0, 0.2), panels, (BLUE, RED, GREEN), "osD", strict=True
    ):
        y = [i + shift for i in range(len(names))]
        dots: Any = {
            "color": colour,
            "marker": marker,
            "linestyle": "none",
            "markersize": 5,
        }
        u = [100 * trial.bias_u for trial in panel.trials]
        bias.errorbar(
            [100 * trial.bias for trial in panel.trials],
            y,
            xerr=u,
            elinewidth=1,
            **dots,
        )
        rmse.plot([100 * trial.rmse for trial in panel.trials], y, **dots)
        coverage.plot(
            [100 * trial.coverage for trial in panel.trials],
            y,
            label=panel.scene.title,
            **dots,
        )
        cost.plot([trial.seconds for trial in panel.trials], y, **dots)
    bias.axvline(0, color=GREY, linewidth=1)
    bias.set(
        title="bias",
        xlabel="mean error of I_zz [%]",
        yticks=range(len(names)),
        yticklabels=names,
    )
    bias.invert_yaxis()
    rmse.set(title="error", xlabel="RMSE of I_zz [%]", xlim=(0, None))
    coverage.axvspan(100 * HONEST[0], 100 * HONEST[1], **BAND)
    coverage.set(title="coverage", xlabel="intervals with true I_zz [%]", xlim=(0, 104))
    cost.set(title="cost", xlabel="time of one fit [s]", xscale="log")
    figure.legend(
        *coverage.get_legend_handles_labels(),
        loc="upper left",
        bbox_to_anchor=(0, 0.94),
        ncols=3,
    )
    return figure


# --- failures ---


def _draw_failures(failures: Sequence[Failure]) -> Figure:
    """Draw for each case the error or coverage of the method that fails and of the solution."""
    figure = _figure(6.6, "Methods that fail (crosses) and their solutions (dots)")
    kinds = [
        [one for one in failures if one.measure == measure]
        for measure in ("relative error", "coverage")
    ]
    errors, covers = figure.subplots(2, 1, height_ratios=[len(kind) for kind in kinds])
    errors.set(
        title="formulas and motions",
        xscale="log",
        xlim=(1e-18, 300),
        xlabel="relative error",
    )
    covers.set(
        title="fits", xlim=(-15, 115), xlabel="true I_zz in the 95 % interval [%]"
    )
    covers.axvspan(100 * HONEST[0], 100 * HONEST[1], **BAND)
    for ax, kind, factor in ((errors, kinds[0], 1), (covers, kinds[1], 100)):
        ax.set(
            yticks=range(len(kind)),
            yticklabels=[one.case for one in kind],
            ylim=(len(kind) - 0.4, -0.7),
        )
        for y, one in enumerate(kind):
            right, wrong = (
                max(factor * value, 1e-16) for value in (one.right, one.wrong)
            )
            ax.plot([wrong, right], [y, y], color="#bbbbbb", linewidth=1.5, zorder=1)
            for x, marker, colour, words in (
                (wrong, "X", RED, one.fails),
                (right, "o", BLUE, one.solution),
            ):
                ax.plot(x, y, marker, color=colour, markersize=8)
                ax.annotate(
                    words,
                    (x, y),
                    (0, 6),
                    textcoords="offset points",
                    ha="center",
                    color=colour,
                    fontsize=8.5,
                )
            place: Any = {
                "transform": ax.get_yaxis_transform(),
                "ha": "center",
                "va": "top",
            }
            ax.text(0.5, y + 0.15, one.why, fontsize=7.5, color=GREY, **place)
    return figure
