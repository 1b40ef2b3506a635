"""The figures of a log.

A figure consists of a function that draws on axes of matplotlib, and an entry in
`FIGURES`. The report, ``Analysis.plot`` and the
feedback for students use this entry.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from textwrap import fill, shorten
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.base import errors
from gyrodata.base.errors import count_text, insist_on_choice, insist_on_type
from gyrodata.physics import RPM, Floats
from gyrodata.reporting.elements import Picture
from gyrodata.reporting.figure_data import (
    COLOURS,
    MARKERS,
    Group,
    Look,
    Quantity,
    Scene,
    gather,
    run_name,
    short_name,
    shown,
)
from gyrodata.reporting.values import p_text, reading_text
from gyrodata.results import Analysis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Form = Literal["png", "svg", "pdf"]

INK, SOFT, BAND, DOUBTED = "#222222", "#666666", "#0072B2", "#8A3B00"

STYLE = Path(__file__).with_suffix(".mplstyle")


class Style(Struct, frozen=True):
    """How large a figure is drawn."""

    width: float
    """[inch]"""
    height: float
    """[inch]"""
    second_panel: float
    """Additional height for a second panel [inch]."""
    font_size: float
    """[point]"""
    resolution: float
    """Of a PNG [dots/inch]."""


STYLES = {
    "screen": Style(5.6, 3.9, 1.8, 9.0, 144),
    "print": Style(3.4, 2.9, 1.3, 6.5, 300),
}
"""Figures for the screen, and for one column of a printed page."""

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "gyrodata"},
    "pdf": {"CreationDate": None, "Creator": "gyrodata", "Producer": None},
}
"""Metadata of each format: without date and version, so that the same log gives the
same bytes."""

MOST_NAMES = 10
"""Largest number of runs that are named in a figure."""

PADDING = 0.4
"""Space around the axes of a figure [font size]."""

MOST_LETTERS = 60
"""Largest number of letters in a line of a heading."""

SPIN_AXIS = "spin ψ̇ [rpm]"
PRODUCT_AXIS = "precession rate × spin, φ̇ψ̇ [rad²/s²]"

# --- the figures ---


def draw_period(ax: Axes, scene: Scene) -> None:
    """Draw the period against the spin, with the fitted line of each torque."""
    left, right = _limits(scene.spin, scene.kept)
    # One turn without a weight may take an hour: such runs do not determine the limits.
    loaded = scene.torque.value != 0
    of_loaded = Quantity(*np.array(scene.period)[:, loaded])
    ax.set_xlim(left, right)
    ax.set_ylim(_limits(of_loaded, scene.kept[loaded]))
    ax.set_xlabel(SPIN_AXIS)
    ax.set_ylabel("precession period τ [s]")
    for group in scene.groups:
        m0 = scene.analysis.fit.balances[group.members[0]]
        net_torque = abs(group.summary.torque + m0)
        if group.summary.torque and net_torque:
            last = 2 * math.pi * scene.inertia * RPM * right / net_torque
            ax.plot((0.0, right), (0.0, last), color=group.look.colour)
    _draw_runs(ax, scene, scene.ranked, scene.spin, scene.period)


def draw_product(ax: Axes, scene: Scene) -> None:
    """Draw φ̇ψ̇ against the spin, with the mean of each torque and its band."""
    ax.set_xlim(_limits(scene.spin, scene.kept))
    ax.set_ylim(_limits(scene.product, scene.kept))
    ax.set_xlabel(SPIN_AXIS)
    ax.set_ylabel("φ̇ψ̇ [rad²/s²]")
    few = len(scene.groups) <= 6
    groups = []
    for group in scene.ranked:
        look = group.look
        product = group.summary.product
        half = 2 * (product.u or 0.0)
        low = product.value - half
        high = product.value + half
        ax.axhspan(low, high, color=look.colour, alpha=0.2, linewidth=0.0)
        ax.axhline(product.value, color=look.colour)
        if few:
            look = look._replace(label=f"{look.label}\n{group.mean}")
        groups.append(Group(look, group.members))
    _draw_runs(ax, scene, groups, scene.spin, scene.product)


def draw_torque(ax: Axes, scene: Scene) -> None:
    """Draw the torque against φ̇ψ̇, with the fitted line and its 95 % band.

    The line through the origin is drawn as well.
    """
    fitted = _fitted_line(scene)
    low, high = _limits(scene.torque, scene.kept)
    space = 0.02 * (high - low)
    low = min(low, float(fitted.torque.min()) - space)
    high = max(high, float(fitted.torque.max()))
    ax.set_xlim(_limits(scene.product, scene.kept))
    ax.set_ylim(low, high)
    ax.set_ylabel(f"torque M [{scene.unit}]")
    _draw_runs(ax, scene, scene.ranked, scene.product, scene.torque)
    _draw_line(ax, scene, fitted, 0.0)


def draw_rest(ax: Axes, scene: Scene) -> None:
    """Draw the difference of each torque and the fitted line, on a larger scale."""
    fitted = _fitted_line(scene)
    # The runs determine the limits; the band may be outside.
    kept = scene.kept | scene.hollow.all()
    of_runs = np.abs(scene.rest.value) + scene.rest.u
    reach = float(of_runs[kept].max())
    of_band = max(fitted.down.max(), fitted.up.max())
    needed = min(max(reach, of_band), 2 * reach)
    limit = 1.1 * needed or 1.0
    ax.set_xlim(_limits(scene.product, scene.kept))
    ax.set_ylim(-limit, limit)
    ax.set_ylabel(f"M − fit [{scene.unit}]")
    product = Quantity(scene.product.value)
    _draw_runs(ax, scene, scene.ranked, product, scene.rest)
    _draw_line(ax, scene, fitted, fitted.torque)


def draw_residuals(ax: Axes, scene: Scene) -> None:
    """Draw each time minus the prediction of the other runs, in the log's order."""
    deviations = np.nan_to_num(scene.analysis.fit.deviations)
    of_kept = np.abs(deviations[scene.kept])
    limit = max(3.5, 1.15 * float(of_kept.max(initial=0.0)))
    number = np.arange(1.0, len(scene.names) + 1)
    right = len(number) + 0.6
    ax.set_xlim(0.4, right)
    ax.set_ylim(-limit, limit)
    ax.set_xlabel("run, in the order of the log")
    ax.set_ylabel("time − prediction [u]")
    # There is space for about 40 letters.
    step = 1 + len("  ".join(scene.names)) // 40
    every = slice(step - 1, None, step)
    ax.set_xticks(number[every], scene.names[every])
    title = "Residuals: as many unknowns as runs"
    if scene.analysis.fit.dof > 0:
        in_fit = np.abs(deviations[~scene.left_out])
        within = int(np.sum(in_fit <= 2))
        title = f"Residuals: {within} of {len(in_fit)} runs within ± 2 u"
    ax.set_title(title, loc="left")
    ax.axhspan(-2.0, 2.0, color=BAND, alpha=0.1, linewidth=0.0)
    _draw_runs(ax, scene, scene.ranked, Quantity(number), Quantity(deviations))


def draw_days(ax: Axes, scene: Scene) -> None:
    """Draw what the torque of each run lacks to I_zz φ̇ψ̇, in the colour of its day."""
    of_spin = scene.inertia * scene.product.value / scene.unit_size
    lacking = Quantity(scene.torque.value - of_spin, scene.rest.u)
    ax.set_xlim(_limits(scene.product, scene.kept))
    ax.set_ylim(_limits(lacking, scene.kept))
    ax.set_xlabel(PRODUCT_AXIS)
    ax.set_ylabel(f"M − I_zz φ̇ψ̇ [{scene.unit}]")
    days = []
    looks = zip(cycle(COLOURS), cycle(MARKERS), strict=False)
    for number, block in enumerate(scene.analysis.blocks):
        colour, marker = next(looks)
        minus_m0 = -block.residual_torque.value / scene.unit_size
        half = (block.residual_torque.u or 0.0) / scene.unit_size
        low = minus_m0 - half
        high = minus_m0 + half
        ax.axhspan(low, high, color=colour, alpha=0.15, linewidth=0.0)
        ax.axhline(minus_m0, color=colour)
        runs = np.flatnonzero(scene.analysis.measurements.day == number)
        look = Look(short_name(block.name, 30), colour, marker)
        days.append(Group(look, runs.tolist()))
    _draw_runs(ax, scene, days, Quantity(scene.product.value), lacking)


class Kind(Struct, frozen=True):
    """One of the figures."""

    panels: tuple[Callable[[Axes, Scene], None], ...]
    """Functions that draw on axes; a second panel is below the first and has the same x
    axis."""
    caption: str
    """Its first sentence says what the figure shows. A number in it is also in the JSON."""
    draws_runs: bool = True
    """Whether each run has a mark in it."""


FIGURES = {
    "period": Kind(
        (draw_period,),
        "Period τ against spin ψ̇. Lines: the fitted law of each torque, τ = 2π I_zz "
        "ψ̇ / |M + M0|. "
        "Bars: one standard uncertainty.",
    ),
    "product": Kind(
        (draw_product,),
        (
            "φ̇ψ̇ against spin, with the mean of each torque and its band, ± 2 u. "
            "Bars: one standard uncertainty."
        ),
    ),
    "torque": Kind(
        (draw_torque, draw_rest),
        "Torque M against φ̇ψ̇ with the recommended line M = I_zz φ̇ψ̇ − M0 and its 95 "
        "% band; dashed: the line through "
        "the origin. Below: torque minus the recommended line. Bars: one standard uncertainty.",
    ),
    "residuals": Kind(
        (draw_residuals,),
        "Each run's time minus the prediction of the other runs, in standard "
        "uncertainties. About 95 % of good runs "
        "are in the band.",
    ),
}
"""The figures of every log by their names, in the order of the report."""

ALL_FIGURES = FIGURES | {
    "days": Kind(
        (draw_days,),
        "Torque M minus I_zz φ̇ψ̇, in the colour of each day or group. With one I_zz, the "
        "runs of each are on its line at −M0; bands and bars: one standard uncertainty.",
    ),
}
"""All figures: several days are compared in one more."""


def figures_of(analysis: Analysis) -> tuple[str, ...]:
    """Return the names of the figures of a log."""
    return tuple(ALL_FIGURES if analysis.blocks else FIGURES)


PICTURES = {name: Picture(name, kind.caption) for name, kind in ALL_FIGURES.items()}
"""Each figure with its caption, as a block of the report."""


# --- parts of figures ---


def _limits(quantity: Quantity, kept: NDArray[np.bool_]) -> tuple[float, float]:
    """Return limits that include zero and the kept runs.

    Other runs extend them by a half at most.
    """
    values, u = quantity
    inside = kept if kept.any() else np.ones_like(kept)
    low = min(0.0, float((values - u)[inside].min()))
    high = max(0.0, float((values + u)[inside].max()))
    half = (high - low or 1.0) / 2
    lowest = min(low, float(values.min()))
    highest = max(high, float(values.max()))
    low = max(lowest, low - half)
    high = min(highest, high + half)
    space = 0.06 * (high - low)
    bottom = low - space if low < 0 else 0.0
    top = high + space if high > 0 else 0.0
    return bottom, top


class FittedLine(NamedTuple):
    """The fitted line with its 95 % band at values of φ̇ψ̇; arrays of one shape."""

    product: Floats
    """φ̇ψ̇ [rad²/s²]"""
    torque: Floats
    """Torque on the line, in the unit of the scene, as the halves of the band."""
    down: Floats
    up: Floats


def _fitted_line(scene: Scene) -> FittedLine:
    """Compute the fitted line and its 95 % band.

    The slope varies within its interval, about the point at which slope and height are
    not correlated; the height at this point has an independent error.
    """
    x = np.linspace(*_limits(scene.product, scene.kept), 41)
    covariance = scene.analysis.fit.covariance[:2, :2]
    (v_inertia, cov), (_, v_imbalance) = covariance
    interval = scene.analysis.inertia.interval_95
    half = 1.96 * math.sqrt(v_inertia)
    low = high = half
    if interval:
        low, high = (abs(end - scene.inertia) for end in interval)
    centre = cov / v_inertia
    v_height = max(v_imbalance - cov * centre, 0.0)
    height = 1.96 * np.sqrt(v_height)
    along = x - centre
    lower = along * np.where(along > 0, low, high)
    upper = along * np.where(along > 0, high, low)
    line = (x * scene.inertia - scene.imbalance) / scene.unit_size
    down = np.hypot(lower, height) / scene.unit_size
    up = np.hypot(upper, height) / scene.unit_size
    return FittedLine(x, line, down, up)


def _draw_line(
    ax: Axes, scene: Scene, fitted: FittedLine, minus: Floats | float
) -> None:
    """Draw the fitted line, its band and the line through the origin, minus a torque."""
    x = fitted.product
    line = fitted.torque - minus
    ax.set_xlabel(PRODUCT_AXIS)
    low, high = line - fitted.down, line + fitted.up
    ax.fill_between(x, low, high, color=BAND, alpha=0.15, linewidth=0.0)
    ax.plot(x, line, color=INK, label="fitted line")
    for fit in scene.analysis.fits:
        if fit.name == "through_origin" and fit.inertia:
            y = fit.inertia.value / scene.unit_size * x - minus
            label = "through the origin"
            ax.plot(x, y, color=SOFT, linestyle="dashed", label=label)


def _draw_runs(
    ax: Axes,
    scene: Scene,
    groups: Sequence[Group],
    x: Quantity,
    y: Quantity,
) -> None:
    """Draw the line of zero, and the runs of each group; flagged ones are named.

    A run outside the axes is drawn at the edge, without bars and with its value.
    """
    ax.axhline(0.0, color=SOFT, linewidth=0.8, zorder=1.5)
    at_x = np.clip(x.value, *ax.get_xlim())
    at_y = np.clip(y.value, *ax.get_ylim())
    inside = (at_x == x.value) & (at_y == y.value)
    points = np.array([at_x, at_y])
    colours = np.full(len(inside), "#000000")
    for rank, group in enumerate(groups):
        colours[group.members] = group.look.colour
        label = group.look.label
        if rank % scene.labelled:
            label = "_"
        _draw_marks(ax, scene, group, points, label)
    if np.any(np.hypot(x.u, y.u)):
        of_bars: Any = list(colours)
        inner_x = np.where(inside, at_x, np.nan)
        ax.errorbar(inner_x, at_y, y.u, x.u, fmt="none", ecolor=of_bars, elinewidth=1.0)
    odd = np.flatnonzero(scene.hollow | ~inside)
    if len(odd) > MOST_NAMES:
        odd = np.flatnonzero(scene.hollow)[:MOST_NAMES]
    for rank, i in enumerate(odd.tolist()):
        name = run_name(scene.names[i]) if scene.hollow[i] else ""
        across = _beyond(x.value[i], at_x[i], "→←")
        up = _beyond(y.value[i], at_y[i], "↑↓")
        text = " ".join(filter(None, [name, across, up]))
        _write_next_to(ax, (at_x[i], at_y[i]), text, rank)
    if scene.hollow.any():
        is_left_out = (scene.left_out == scene.hollow).all()
        meaning = "left out" if is_left_out else "flagged"
        ax.plot(
            [],
            [],
            linestyle="none",
            marker="o",
            markerfacecolor="white",
            color=SOFT,
            label=f"hollow: {meaning}",
        )
    if not inside.all():
        ax.plot([], [], label="at the edge:\nnot shown on this axis", linestyle="none")


def _draw_marks(
    ax: Axes, scene: Scene, group: Group, points: Floats, label: str
) -> None:
    """Draw the runs of one group, full or hollow; the first ones are in the legend.

    `points` contains x and y of all runs, shape (2, n).
    """
    colour = group.look.colour
    for hollow in (False, True):
        members = [i for i in group.members if scene.hollow[i] == hollow]
        if not members:
            continue
        ax.plot(
            *points[:, members],
            linestyle="none",
            marker=group.look.marker,
            color=colour,
            markerfacecolor="white" if hollow else colour,
            markeredgecolor=colour if hollow else "white",
            markeredgewidth=1.3 if hollow else 0.5,
            zorder=4 if hollow else 3,
            clip_on=False,
            label=label,
        )
        label = "_"


def _beyond(value: float, shown: float, arrows: str) -> str:
    """Write a value outside the axes, with an arrow to it; "" if inside."""
    if value == shown:
        return ""
    arrow = arrows[0] if value > shown else arrows[1]
    return f"{arrow} {reading_text(value)}".replace("-", "−")


def _write_next_to(ax: Axes, mark: tuple[float, float], text: str, rank: int) -> None:
    """Write a text next to a mark, on the side towards the middle of the axes.

    Neighbours by their rank are at three heights.
    """
    x, y = mark
    is_left = x < np.mean(ax.get_xlim())
    is_low = y < np.mean(ax.get_ylim())
    away = 10 + 11 * (rank % 3)
    ax.annotate(
        text,
        mark,
        (5 if is_left else -5, away if is_low else -away),
        textcoords="offset points",
        ha="left" if is_left else "right",
        va="center",
        fontsize=7.5,
        zorder=5,
        bbox={"facecolor": "white", "alpha": 0.75, "lw": 0, "pad": 0.5},
        arrowprops={"arrowstyle": "-", "color": SOFT, "lw": 0.5},
    )


# --- figures and files ---


def _fill(figure: Figure, scene: Scene, name: str) -> Axes:
    """Draw one of `ALL_FIGURES` with its legend and heading, and return its main axes."""
    kind = ALL_FIGURES[name]
    panels = kind.panels
    subplots = figure.subplots(len(panels), sharex=True, squeeze=False)
    axes: list[Axes] = list(subplots.flat)
    handles: dict[str, Any] = {}
    for ax, draw in zip(axes, panels, strict=True):
        ax.locator_params(nbins=5)
        draw(ax, scene)
        ax.label_outer()
        drawn, labels = ax.get_legend_handles_labels()
        handles |= zip(labels, drawn, strict=True)
    title = None
    if kind.draws_runs and scene.labelled > 1:
        title = f"1 in {scene.labelled} of {len(scene.groups)} torques"
    figure.legend(
        list(handles.values()),
        list(handles),
        loc="outside lower left",
        ncols=2,
        title=title,
    )
    heading = "\n".join([fill(fact, MOST_LETTERS) for fact in _facts(scene)])
    colour = DOUBTED if scene.analysis.doubts else INK
    figure.suptitle(heading, x=0.01, y=0.99, ha="left", fontsize="medium", color=colour)
    return axes[0]


def _facts(scene: Scene) -> list[str]:
    """List the log, its result, how well the runs agree, and a doubt if there is one."""
    analysis = scene.analysis
    numbers = scene.numbers
    runs = count_text(len(scene.names), "run")
    m0 = numbers.value("residual_torque.value")
    quality = "no degrees of freedom"
    if analysis.p is not None:
        per_dof = analysis.fit.chi2 / analysis.fit.dof
        quality = f"χ²/dof = {per_dof:.2g}, {p_text(analysis.p)}"
    log = short_name(analysis.name, 50)
    answer = shown(numbers.answer())
    facts = [f"{log}, {runs}", answer, f"M0 = {shown((m0,))}; {quality}"]
    if analysis.doubts:
        reason = shorten(analysis.doubts[0].words, 150, placeholder=" …")
        # A number stays on the line of its per cent.
        reason = reason.replace(" %", "\u00a0%")
        facts.append(f"Do not rely on this answer: {reason}")
    return facts


def plot_on(analysis: Analysis, name: str, ax: Axes | None = None) -> Axes:
    """Draw one of `ALL_FIGURES` on axes.

    Without axes, on a new figure with its legend and second panel.

    Raises
    ------
    ValueError, TypeError
        If the name is unknown, or if `ax` is not an ``Axes``.
    """
    from matplotlib.axes import Axes

    insist_on_choice("name", name, figures_of(analysis))
    insist_on_type("ax", ax, Axes | None, "axes of matplotlib")
    scene = gather(analysis)
    if ax is None:
        from matplotlib import pyplot

        return _fill(pyplot.figure(layout="constrained"), scene, name)
    ALL_FIGURES[name].panels[0](ax, scene)
    return ax


def render(
    analysis: Analysis,
    forms: Sequence[Form],
    style: str = "screen",
    names: Sequence[str] | None = None,
    faults: dict[str, str] | None = None,
) -> dict[Form, dict[str, bytes]]:
    """Draw figures once, and write each as files of one or more types.

    Parameters
    ----------
    analysis : Analysis
    forms : sequence of {"png", "svg", "pdf"}
        File types.
    style : {"screen", "print"}
        Size and resolution.
    names : sequence of str, optional
        Which figures; by default all of the log.
    faults : dict, optional
        Receives why figures cannot be drawn, by their names. Without it, the first
        error is raised.

    Returns
    -------
    dict of str to dict
        By file type: the files of the figures that can be drawn, by name.
    """
    scene = gather(analysis)
    names = names or figures_of(analysis)
    files: dict[Form, dict[str, bytes]] = {form: {} for form in forms}
    try:
        import matplotlib.figure
    except (ImportError, ValueError) as error:
        # A damaged installation, or a matplotlibrc that is not UTF-8.
        if faults is None:
            raise
        faults |= dict.fromkeys(names, _reason(error))
        return files
    with own_style(), warnings.catch_warnings():
        matplotlib.rcParams["font.size"] = STYLES[style].font_size
        # The font may not contain the letters of a name; it then draws boxes.
        warnings.filterwarnings("ignore", message="(?s).*[Gg]lyph.* missing")
        for name in names:
            try:
                drawn = _draw(scene, name, forms, style)
            except Exception as error:
                # The answer does not depend on a figure, nor on the state of
                # matplotlib.
                if faults is None:
                    raise
                faults[name] = _reason(error)
                continue
            for form, data in drawn.items():
                files[form][name] = data
    return files


def _reason(error: Exception) -> str:
    """Say in one line why a figure cannot be drawn."""
    reason = f"{type(error).__name__}: {error}"
    return errors.shown(reason)[:200]


def _draw(
    scene: Scene, name: str, forms: Sequence[Form], style: str
) -> dict[Form, bytes]:
    """Draw one figure; return its files by their types."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import TightLayoutEngine

    size = STYLES[style]
    second_panels = len(ALL_FIGURES[name].panels) - 1
    height = size.height + size.second_panel * second_panels
    figure = Figure((size.width, height), size.resolution)
    _fill(figure, scene, name)
    # A figure that has a layout engine is drawn twice for each file. This one measures
    # each text once; it leaves no space for a legend below the axes.
    TightLayoutEngine(pad=PADDING, rect=None).execute(figure)  # type: ignore[arg-type]
    legend = figure.legends[0].get_window_extent()
    bottom = figure.subplotpars.bottom + legend.height / figure.bbox.height
    figure.subplots_adjust(bottom=bottom)
    return {form: save(figure, form) for form in forms}


@contextmanager
def own_style(*files: Path) -> Iterator[None]:
    """Draw with the defaults of matplotlib, the style of the figures, and other styles.

    The user's matplotlibrc does not change the drawing.
    """
    import matplotlib

    with matplotlib.rc_context(matplotlib.rcParamsDefault):
        for file in (STYLE, *files):
            settings = matplotlib.rc_params_from_file(file, use_default_template=False)
            matplotlib.rcParams.update(settings)
        yield


def save(figure: Figure, form: Form, compress_level: int = 1) -> bytes:
    """Return the bytes of a figure's file.

    A PNG of level 9 is smaller than one of level 1, but slow.
    """
    file = io.BytesIO()
    options: dict[str, Any] = {}
    if form == "png":
        options["pil_kwargs"] = {"compress_level": compress_level}
    figure.savefig(file, format=form, metadata=METADATA[form], **options)
    return file.getvalue()


def alternatives(analysis: Analysis) -> dict[str, str]:
    """Describe each figure, for readers who cannot see it.

    The report has a table of its numbers next to it. The text does not repeat the
    answer, which a report states once.
    """
    scene = gather(analysis)
    log, _, *quality = _facts(scene)
    odd = []
    for i in np.flatnonzero(scene.hollow).tolist():
        fate = ", left out" if scene.left_out[i] else ""
        odd.append(f"{run_name(scene.names[i])}{fate}")
    facts = f"{log}; {'; '.join(quality)}."
    texts = {}
    for name in figures_of(analysis):
        figure = ALL_FIGURES[name]
        shows = figure.caption.partition(". ")[0]
        texts[name] = f"{shows}. {facts}"
        if odd and figure.draws_runs:
            texts[name] += f" Drawn hollow: {'; '.join(odd)}."
    return texts
