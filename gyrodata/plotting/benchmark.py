"""The charts of `gyro benchmark`, as files."""

from __future__ import annotations

from collections.abc import Sequence

from gyrodata.benchmark import Benchmark
from gyrodata.plotting.benchmark_motion import draw_motion
from gyrodata.plotting.benchmark_stability import draw_breakdowns, draw_maps, draw_upright
from gyrodata.plotting.benchmark_trials import draw_trials
from gyrodata.plotting.style import STYLE, Form, save


def render_benchmark(benchmark: Benchmark, forms: Sequence[Form] = ("png", "svg")) -> dict[str, bytes]:
    """Draw every chart as files.

    Parameters
    ----------
    benchmark : Benchmark
    forms : sequence of {"png", "svg", "pdf"}

    Returns
    -------
    dict of str to bytes
        By file name; the same for the same benchmark. A PNG is 1350 dots wide.
    """
    from matplotlib import rc_context

    figures = {
        "motion": draw_motion(benchmark.motion),
        "estimators": draw_trials(benchmark.trials),
        "stability_steady": draw_maps(benchmark.roots),
        "stability_integrators": draw_maps(benchmark.integrators),
        "stability_upright": draw_upright(benchmark.passages),
        "stability_estimators": draw_breakdowns(benchmark.breakdowns),
    }
    with rc_context(STYLE):
        return {f"{name}.{form}": save(figure, form) for name, figure in figures.items() for form in forms}
