"""``gyro predict``: what theory predicts for given numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.cli.options import FormatOption, quantity, quantity_option, read
from gyrodata.cli.terminal import Door, refuse, write_answer

if TYPE_CHECKING:
    from gyrodata.physics.prediction import Earth, Platform, Precession, Tip, Twist
    from gyrodata.results import Analysis

predict = typer.Typer(
    cls=Door, add_completion=False, suggest_commands=False, rich_markup_mode=None
)


@predict.callback()
def _predict() -> None:
    """Predict by theory: precession, the rotating Earth, a wheel, a force on the tip.

    Each command also works without options. --log reads I_zz and the fastest spin from
    your own log.
    """


Inertia = Annotated[
    Any,
    quantity_option(
        "--inertia",
        "inertia",
        "above zero",
        words="I_zz about the rod. Default: 4.44e-3 kg m^2.",
    ),
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
        words="Spin; counterclockwise seen from the tip is positive. Default: 400 rpm.",
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
LogOption = Annotated[
    str | None,
    typer.Option(
        "--log",
        metavar="LOG",
        help="Read numbers that no option gives from this log.",
    ),
]


USUAL = {
    "inertia": ("inertia", "4.44e-3 kg m^2"),
    "transverse": ("inertia", ""),
    "spin": ("rate", "400 rpm"),
    "mass": ("mass", "60 g"),
    "position": ("length", "15 cm"),
    "g": ("acceleration", "9.80665 m/s^2"),
    "latitude": ("angle", "42.5 deg"),
}
"""Kind and default value of each number that a log can give."""


class _Numbers(Struct):
    """The numbers of a prediction that no option gives."""

    log: str
    """Name of the log."""
    of_log: dict[str, float]
    """The log's values by option [SI units]."""
    notes: list[str]
    """Where each number comes from."""

    def get(self, name: str, given: float | None, usual: str = "") -> float:
        """Return the value of an option, of the log, or the usual one [SI unit]."""
        from gyrodata.quantities.units import DISPLAY, from_si

        if given is not None:
            return given
        kind, text = USUAL[name]
        if name in self.of_log:
            value = self.of_log[name]
            unit = DISPLAY[kind]
            text = f"{from_si(value, unit, kind):.6g} {unit}"
            origin = f"from {self.log}"
        else:
            text = usual or text
            value = quantity(name, text, kind)
            origin = "the default value"
        self.notes.append(f'--{name} "{text}", {origin}')
        return value

    def transverse(
        self, given: float | None, inertia: float, load: float = 0.0
    ) -> float:
        """Return I across the rod [kg*m^2]; `load` is m x^2 of the weight."""
        from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO

        usual = f"{DEFAULT_TRANSVERSE_RATIO * inertia + load:.9g} kg m^2"
        across = self.get("transverse", given, usual)
        if across < inertia / 2:
            refuse("transverse_impossible", across=across)
        return across


def _numbers_of(log: str | None) -> _Numbers:
    """Analyse the log, if there is one; a log that is refused ends the command."""
    if log is None:
        return _Numbers("", {}, [])
    from gyrodata.analysis import analyze_readings

    analysis = analyze_readings(read([log]))
    doubts = [f"do not rely on I_zz: {doubt.words}" for doubt in analysis.doubts]
    return _Numbers(analysis.name, _values_of(analysis), doubts)


def _values_of(analysis: Analysis) -> dict[str, float]:
    """Return what a log says of its fastest run, by option [SI units]."""
    measured = analysis.measurements
    runs = analysis.run_table
    kept = [i for i, run in enumerate(runs) if not run.left_out]
    fastest = sorted(kept, key=lambda i: -abs(measured.spin[i]))
    values = {
        "inertia": analysis.inertia.value,
        "spin": float(measured.spin[fastest[0]]),
        "g": measured.g,
    }
    if measured.latitude is not None:
        values["latitude"] = measured.latitude
    for i in fastest:
        mass = runs[i].mass
        position = runs[i].position
        if not mass or not position:
            continue
        values["mass"] = mass
        # A column may contain the side of the rod; then it is in the sign of the torque
        # only.
        values["position"] = math.copysign(position, runs[i].torque)
        across = measured.transverse_inertia
        if across is not None and math.isfinite(across[i]):
            values["transverse"] = float(across[i])
        break
    return values


@predict.command()
def precession(
    inertia: Inertia = None,
    spin: Spin = None,
    transverse: Transverse = None,
    mass: Annotated[
        Any,
        quantity_option(
            "--mass",
            "mass",
            "zero or above",
            words="Mass of the weight. Default: 60 g.",
        ),
    ] = None,
    position: Annotated[
        Any,
        quantity_option(
            "--position", "length", words="Position on the rod. Default: 15 cm."
        ),
    ] = None,
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
        quantity_option(
            "--g",
            "acceleration",
            "above zero",
            words="Gravity. Default: 9.80665 m/s^2.",
        ),
    ] = None,
    log: LogOption = None,
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

    numbers = _numbers_of(log)
    if mass is not None or position is not None:
        # The log has this inertia for its own weight.
        numbers.of_log.pop("transverse", None)
    values = {
        "inertia": numbers.get("inertia", inertia),
        "spin": numbers.get("spin", spin),
        "pitch": pitch,
        "mass": numbers.get("mass", mass),
        "position": numbers.get("position", position),
        "g": numbers.get("g", g),
    }
    load = values["mass"], values["position"], values["g"]
    values["torque"] = float(physics.torque(*load))
    values["transverse_inertia"] = numbers.transverse(
        transverse, values["inertia"], values["mass"] * values["position"] ** 2
    )
    names = ("torque", "spin", "inertia", "transverse_inertia", "pitch")
    answer = predict_precession(*(values[name] for name in names))
    _write(answer, values, numbers.notes, form)


@predict.command()
def earth(
    latitude: Annotated[
        Any,
        quantity_option(
            "--latitude",
            "angle",
            "from -90 to 90 degrees",
            words="Latitude; negative in the south. Default: 42.5 deg, as in the lab "
            "sheet.",
        ),
    ] = None,
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
    inertia: Inertia = None,
    spin: Annotated[
        Any,
        quantity_option(
            "--spin",
            "rate",
            "other than zero",
            words="Spin; counterclockwise seen from the tip is positive. Default: 400 "
            "rpm.",
        ),
    ] = None,
    log: LogOption = None,
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

    numbers = _numbers_of(log)
    values = {
        "latitude": numbers.get("latitude", latitude),
        "hours": hours,
        "inertia": numbers.get("inertia", inertia),
        "spin": numbers.get("spin", spin),
    }
    rows = [row * step for row in range(math.ceil(hours / step - 1e-9))]
    times = [3600 * row for row in (*rows, hours)]
    answer = predict_earth(values["latitude"], times, values["inertia"], values["spin"])
    _write(answer, values, numbers.notes, form)


@predict.command()
def platform(
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

    values = {
        "wheel_inertia": wheel_inertia,
        "wheel_spin": wheel_spin,
        "platform_inertia": platform_inertia,
        "from": start,
        "to": end,
    }
    _write(predict_platform(*values.values()), values, [], form)


@predict.command()
def twist(
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

    values = {
        "wheel_inertia": wheel_inertia,
        "wheel_spin": wheel_spin,
        "time": time,
        "handles": handles,
    }
    _write(predict_twist(*values.values()), values, [], form)


@predict.command()
def tip(
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
    inertia: Inertia = None,
    spin: Spin = None,
    transverse: Transverse = None,
    log: LogOption = None,
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

    numbers = _numbers_of(log)
    values = {
        "force": force,
        "length": length,
        "inertia": numbers.get("inertia", inertia),
        "spin": numbers.get("spin", spin),
    }
    # That of the log is with its weight.
    numbers.of_log.pop("transverse", None)
    values["transverse_inertia"] = numbers.transverse(transverse, values["inertia"])
    _write(predict_tip(*values.values()), values, numbers.notes, form)


def _write(
    answer: Precession | Earth | Platform | Twist | Tip,
    values: dict[str, float],
    notes: list[str],
    form: str,
) -> None:
    """Print a prediction with the numbers that it is for."""
    from gyrodata.physics.prediction import prediction_text
    from gyrodata.results import to_json

    answer = replace(answer, options=values, notes=tuple(notes))
    write_answer(form, to_json(answer), prediction_text(answer))
