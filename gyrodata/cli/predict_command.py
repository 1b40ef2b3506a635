"""``gyro predict``: what theory predicts for given numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer
from msgspec.structs import replace

from gyrodata.cli.options import FormatOption, quantity_option, read
from gyrodata.cli.terminal import Door, refuse, write_answer

if TYPE_CHECKING:
    from gyrodata.physics.prediction import Earth, Platform, Precession, Tip, Twist
    from gyrodata.results import Analysis

predict = typer.Typer(
    name="predict",
    cls=Door,
    add_completion=False,
    suggest_commands=False,
    rich_markup_mode=None,
)


@predict.callback()
def _predict() -> None:
    """Predict by theory: precession, the rotating Earth, a wheel, a force on the tip.

    Each command also works without options. --log reads I_zz, the fastest spin and the
    weight of that run from your own log.
    """


INERTIA = "4.44e-3 kg m^2"
SPIN = "400 rpm"
"""The ball of the lab sheet, and a usual spin."""

Inertia = Annotated[
    Any,
    quantity_option("--inertia", "inertia", "above zero", words="I_zz about the rod."),
]
Transverse = Annotated[
    Any,
    quantity_option(
        "--transverse",
        "inertia",
        "above zero",
        words="I about an axis across the rod through the centre, with any weight on it. "
        "Default: 1.3 I_zz, plus m x^2 of a weight.",
    ),
]
Spin = Annotated[
    Any,
    quantity_option(
        "--spin",
        "rate",
        words="Spin; counterclockwise seen from the tip is positive.",
    ),
]
WheelInertia = Annotated[
    Any,
    quantity_option(
        "--wheel-inertia",
        "inertia",
        "above zero",
        words="Moment of inertia of the wheel about its axle.",
    ),
]


def _analyze(context: typer.Context, log: str | None) -> Any:
    """Analyze the log of --log; its values take the place of the default values."""
    if log is None:
        return None
    from gyrodata.analysis import analyze_readings

    analysis = analyze_readings(read([log]))
    context.default_map = dict(_values_of(analysis))
    return analysis


LogOption = Annotated[
    Any,
    typer.Option(
        "--log",
        metavar="LOG",
        is_eager=True,
        callback=_analyze,
        help="Read numbers that no option gives from this log.",
    ),
]


def _values_of(analysis: Analysis) -> Iterator[tuple[str, str]]:
    """Yield what a log says of its fastest run, by the names of the options."""
    from gyrodata.physics import RPM

    measured = analysis.measurements
    runs = [run for run in analysis.run_table if not run.left_out]
    runs.sort(key=lambda run: -abs(run.spin))
    yield "inertia", f"{analysis.inertia.value:.12g} kg*m^2"
    yield "spin", f"{runs[0].spin / RPM:.12g} rpm"
    yield "g", f"{measured.g:.12g} m/s^2"
    if measured.latitude is not None:
        yield "latitude", f"{math.degrees(measured.latitude):.12g} deg"
    for run in runs:
        if run.mass and run.position:
            # A column may contain the side of the rod; then it is in the sign of the
            # torque only.
            position = math.copysign(run.position, run.torque)
            yield "mass", f"{1e3 * run.mass:.12g} g"
            yield "position", f"{100 * position:.12g} cm"
            break


def _across(given: float | None, inertia: float, load: float = 0.0) -> float:
    """Return I across the rod [kg*m^2]; `load` is m x^2 of the weight."""
    from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO

    if given is None:
        return DEFAULT_TRANSVERSE_RATIO * inertia + load
    if given < inertia / 2:
        refuse("transverse_impossible", across=given)
    return given


@predict.command()
def precession(
    context: typer.Context,
    *,
    inertia: Inertia = INERTIA,
    spin: Spin = SPIN,
    transverse: Transverse = None,
    mass: Annotated[
        Any,
        quantity_option(
            "--mass",
            "mass",
            "zero or above",
            words="Mass of the weight.",
        ),
    ] = "60 g",
    position: Annotated[
        Any,
        quantity_option("--position", "length", words="Position on the rod."),
    ] = "15 cm",
    pitch: Annotated[
        Any,
        quantity_option(
            "--pitch",
            "angle",
            "below 90 degrees",
            words="Angle of the rod above the horizontal.",
        ),
    ] = "0 deg",
    g: Annotated[
        Any,
        quantity_option("--g", "acceleration", "above zero", words="Gravity."),
    ] = "9.80665 m/s^2",
    analysis: LogOption = None,
    form: FormatOption = "text",
) -> None:
    r"""Predict steady precession, and a released or upright rod.

    There are both roots of eq. (8), and eq. (9). The spin is relative to the frame that
    follows the rod. If there is no steady precession, JSON has null and the reason.
    --log also reads the weight of the log's fastest run.

    Example:  gyro predict precession --mass 60g \
                --position 15cm --spin 400rpm --pitch 10deg
    """
    from gyrodata import physics
    from gyrodata.physics.prediction import predict_precession

    torque = float(physics.torque(mass, position, g))
    across = _across(transverse, inertia, mass * position**2)
    answer = predict_precession(torque, spin, inertia, across, pitch)
    computed = {"torque": torque, "transverse_inertia": across}
    _write(answer, context, form, analysis, **computed)


@predict.command()
def earth(
    context: typer.Context,
    *,
    latitude: Annotated[
        Any,
        quantity_option(
            "--latitude",
            "angle",
            "from -90 to 90 degrees",
            words="Latitude; negative in the south. That of the lab sheet is 42.5 deg.",
        ),
    ] = "42.5 deg",
    hours: Annotated[
        float,
        typer.Option(
            metavar="HOURS",
            min=0.1,
            max=1000,
            help="Duration in hours of the clock.",
        ),
    ] = 24,
    step: Annotated[
        float,
        typer.Option(
            metavar="HOURS", min=0.1, max=1000, help="Hours between two rows."
        ),
    ] = 1,
    inertia: Inertia = INERTIA,
    spin: Annotated[
        Any,
        quantity_option(
            "--spin",
            "rate",
            "other than zero",
            words="Spin; counterclockwise seen from the tip is positive.",
        ),
    ] = SPIN,
    analysis: LogOption = None,
    form: FormatOption = "text",
) -> None:
    r"""Predict the directions of gyroscopes as the Earth rotates.

    Both are balanced. One starts along the Earth's axis, to the pole that is above the
    horizon. The other starts level, to the east. A sidereal hour is 59 min 50.2 s of
    the clock; each row has both. I_zz and the spin determine how well the ball has to
    be balanced for this.

    Example:  gyro predict earth --latitude 42.5deg \
                --hours 24 --step 3
    """
    from gyrodata.physics.prediction import predict_earth

    rows = [row * step for row in range(math.ceil(hours / step - 1e-9))]
    times = [3600 * row for row in (*rows, hours)]
    answer = predict_earth(latitude, times, inertia, spin)
    _write(answer, context, form, analysis, hours=hours)


@predict.command()
def platform(
    context: typer.Context,
    *,
    wheel_inertia: WheelInertia = "0.1 kg m^2",
    wheel_spin: Annotated[
        Any,
        quantity_option(
            "--wheel-spin",
            "rate",
            words="Spin; positive: counterclockwise from above, if the axle points up.",
        ),
    ] = "200 rpm",
    platform_inertia: Annotated[
        Any,
        quantity_option(
            "--platform-inertia",
            "inertia",
            "above zero",
            words="Moment of inertia of platform, person and wheel about the vertical.",
        ),
    ] = "3 kg m^2",
    start: Annotated[
        Any,
        quantity_option(
            "--from",
            "angle",
            words="Angle of the wheel's axle above the horizontal, before.",
        ),
    ] = "0 deg",
    end: Annotated[
        Any, quantity_option("--to", "angle", words="The same angle, after.")
    ] = "90 deg",
    form: FormatOption = "text",
) -> None:
    r"""Predict the rotation of a turntable as a wheel is tipped.

    The wheel spins, and the turntable is at rest before. The angular momentum about the
    vertical does not change.

    Example:  gyro predict platform --wheel-spin 200rpm \
                --from 0deg --to 90deg
    """
    from gyrodata.physics.prediction import predict_platform

    wheel = wheel_inertia, wheel_spin
    answer = predict_platform(*wheel, platform_inertia, start, end)
    _write(answer, context, form)


@predict.command()
def twist(
    context: typer.Context,
    *,
    wheel_inertia: WheelInertia = "0.1 kg m^2",
    wheel_spin: Annotated[
        Any,
        quantity_option(
            "--wheel-spin",
            "rate",
            words="Spin; counterclockwise seen from your right hand is positive.",
        ),
    ] = "200 rpm",
    time: Annotated[
        Any,
        quantity_option(
            "--time",
            "time",
            "above zero",
            words="Time in which the axle is turned over, by half a turn.",
        ),
    ] = "1 s",
    handles: Annotated[
        Any,
        quantity_option(
            "--handles", "length", "above zero", words="Distance between your hands."
        ),
    ] = "40 cm",
    form: FormatOption = "text",
) -> None:
    """Predict the torque on your hands as a wheel is turned over.

    The wheel spins. Its axle is level, with one end in each hand, and turns at a steady
    rate W. This needs a torque I w W, at right angles to the motion of the axle.

    Example:  gyro predict twist --wheel-spin 200rpm --time 1s
    """
    from gyrodata.physics.prediction import predict_twist

    answer = predict_twist(wheel_inertia, wheel_spin, time, handles)
    _write(answer, context, form)


@predict.command()
def tip(
    context: typer.Context,
    *,
    force: Annotated[
        Any,
        quantity_option(
            "--force",
            "force",
            "above zero",
            words="Force across the rod, steady in size and direction.",
        ),
    ] = "0.1 N",
    length: Annotated[
        Any,
        quantity_option(
            "--length",
            "length",
            "above zero",
            words="Distance from the centre of the ball to the tip.",
        ),
    ] = "20 cm",
    inertia: Inertia = INERTIA,
    spin: Spin = SPIN,
    transverse: Transverse = None,
    analysis: LogOption = None,
    form: FormatOption = "text",
) -> None:
    r"""Predict the motion of the rod's tip under a steady force.

    The tip moves at right angles to the force, along the torque. For a fast spin w its
    speed is F L^2/(I_zz w); for a slow spin the exact motion is used. Without spin it
    moves along the force.

    Example:  gyro predict tip --force 0.5N --length 20cm \
                --spin 400rpm
    """
    from gyrodata.physics.prediction import predict_tip

    across = _across(transverse, inertia)
    answer = predict_tip(force, length, inertia, spin, across)
    _write(answer, context, form, analysis, transverse_inertia=across)


def _write(
    answer: Precession | Earth | Platform | Twist | Tip,
    context: Any,
    form: str,
    analysis: Analysis | None = None,
    **computed: float,
) -> None:
    """Print a prediction with the numbers of its options, and where they come from."""
    from gyrodata.physics.prediction import prediction_text
    from gyrodata.results import to_json

    doubts = analysis.doubts if analysis else ()
    notes = [f"do not rely on I_zz: {doubt.words}" for doubt in doubts]
    values = {}
    for option in context.command.params:
        if option.metavar != "QUANTITY":
            continue
        flag = option.opts[0]
        values[flag.strip("-").replace("-", "_")] = context.params[option.name]
        source = context.get_parameter_source(option.name).name
        if analysis and source == "DEFAULT_MAP":
            text = context.default_map[option.name]
            notes.append(f'{flag} "{text}", from {analysis.name}')
        elif source == "DEFAULT":
            text = option.default or f"{computed['transverse_inertia']:.9g} kg m^2"
            notes.append(f'{flag} "{text}", the default value')
    values.pop("transverse", None)
    answer = replace(answer, options=values | computed, notes=tuple(notes))
    write_answer(form, to_json(answer), prediction_text(answer))
