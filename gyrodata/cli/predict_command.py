"""``gyro predict``: what theory predicts for given numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.cli.options import Bound, FormatOption, constants_of, example_of, quantity
from gyrodata.cli.terminal import Door, names_of, refuse, source_of, write_out

if TYPE_CHECKING:
    from gyrodata.prediction import Earth, Platform, Precession, Tip, Twist

predict = typer.Typer(
    cls=Door,
    help="Predict by theory: precession, the rotating Earth, a wheel in your hands, a force on the tip. Each command "
    "also works without options. --log reads I_zz and the fastest spin from your own log.",
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _option(name: str, text: str) -> Any:
    return typer.Option(name, metavar="QUANTITY", help=text)


LogOption = Annotated[
    str | None, typer.Option("--log", metavar="LOG", help="Read numbers that no option gives from this log.")
]
InertiaOption = Annotated[str | None, _option("--inertia", "I_zz about the rod. Default: 4.44e-3 kg m^2.")]
SpinOption = Annotated[
    str | None, _option("--spin", "Spin; counterclockwise seen from the tip is positive. Default: 400 rpm.")
]
TransverseOption = Annotated[
    str | None,
    _option("--transverse", "I about an axis across the rod through the centre, with any weight on it. Default: "
            "1.3 I_zz, plus m x^2 of a weight."),
]  # fmt: skip
WheelInertiaOption = Annotated[str, _option("--wheel-inertia", "Moment of inertia of the wheel about its axle.")]


class _Numbers(Struct):
    """The numbers of a prediction that may come from an option, from the log or from a default value."""

    name: str
    """Name of the log."""
    of_log: dict[str, float]
    """The log's values by option [SI units]."""
    notes: list[str]
    """Where each number comes from that no option gives."""

    def get(self, option: str, text: str | None, kind: str, usual: str, bound: Bound = "") -> float:
        """Return the value of an option, else that of the log, else the usual one [SI unit]."""
        from gyrodata.units import DISPLAY, from_si

        if text is not None:
            return quantity(option, text, kind, bound)
        if option not in self.of_log:
            self.notes.append(f'{option} "{usual}", the default value')
            return quantity(option, usual, kind, bound)
        value, unit = self.of_log[option], DISPLAY[kind]
        self.notes.append(f'{option} "{from_si(value, unit, kind):.6g} {unit}", from {self.name}')
        return value

    def transverse(self, text: str | None, inertia: float, load: float = 0.0) -> float:
        """Return I about an axis across the rod [kg*m^2]; `load` is m x^2 of the weight."""
        from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO

        usual = f"{DEFAULT_TRANSVERSE_RATIO * inertia + load:.9g} kg m^2"
        across = self.get("--transverse", text, "inertia", usual, "above zero")
        if across < inertia / 2:
            refuse("transverse_impossible", across=across)
        return across


def _read(log: str | None) -> _Numbers:
    """Analyse the log, if there is one; a log that is refused ends the command."""
    if log is None:
        return _Numbers("", {}, [])
    from gyrodata.analysis import analyze

    [name] = names_of([log])
    found = analyze(source_of(log, name)["source"], name=name, config=constants_of(log, None))
    measured, runs = found.measurements, found.run_table
    fastest = sorted((i for i, run in enumerate(runs) if not run.left_out), key=lambda i: -abs(measured.spin[i]))
    values = {"--inertia": found.inertia.value, "--spin": float(measured.spin[fastest[0]]), "--g": measured.g}
    if measured.latitude is not None:
        values["--latitude"] = measured.latitude
    for i in fastest:
        mass, position = runs[i].mass, runs[i].position
        if mass and position:
            # A column may contain the side of the rod; then it is in the sign of the torque only.
            values |= {"--mass": mass, "--position": math.copysign(position, runs[i].torque)}
            if measured.transverse_inertia is not None and math.isfinite(measured.transverse_inertia[i]):
                values["--transverse"] = float(measured.transverse_inertia[i])
            break
    return _Numbers(name, values, [f"do not rely on I_zz: {doubt.words}" for doubt in found.doubts])


@predict.command(
    short_help="Steady precession, and a rod that is released or upright.",
    epilog=example_of("gyro predict precession --mass 60g", "--position 15cm --spin 400rpm --pitch 10deg"),
)
def precession(
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    transverse: TransverseOption = None,
    mass: Annotated[str | None, _option("--mass", "Mass of the weight. Default: 60 g.")] = None,
    position: Annotated[str | None, _option("--position", "Position on the rod. Default: 15 cm.")] = None,
    pitch: Annotated[str, _option("--pitch", "Angle of the rod above the horizontal.")] = "0 deg",
    g: Annotated[str | None, _option("--g", "Gravity. Default: 9.80665 m/s^2.")] = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """Predict steady precession, and the motion of a rod that is released or upright.

    There are both roots of eq. (8), and eq. (9). The spin is relative to the frame that follows the rod. If there is
    no steady precession, JSON has null and the reason. --log also reads the weight of the log's fastest run.
    """
    from gyrodata import physics
    from gyrodata.prediction import predict_precession

    numbers = _read(log)
    if mass is not None or position is not None:
        # The log has this inertia for its own weight.
        numbers.of_log.pop("--transverse", None)
    values = {
        "inertia": numbers.get("--inertia", inertia, "inertia", "4.44e-3 kg m^2", "above zero"),
        "spin": numbers.get("--spin", spin, "rate", "400 rpm"),
        "pitch": quantity("--pitch", pitch, "angle", "below 90 degrees"),
        "mass": numbers.get("--mass", mass, "mass", "60 g", "zero or above"),
        "position": numbers.get("--position", position, "length", "15 cm"),
        "g": numbers.get("--g", g, "acceleration", "9.80665 m/s^2", "above zero"),
    }
    values["torque"] = float(physics.torque(values["mass"], values["position"], values["g"]))
    load = values["mass"] * values["position"] ** 2
    values["transverse_inertia"] = numbers.transverse(transverse, values["inertia"], load)
    names = ("torque", "spin", "inertia", "transverse_inertia", "pitch")
    _write(predict_precession(*(values[name] for name in names)), values, numbers, form)


@predict.command(
    short_help="Directions of balanced gyroscopes as the Earth rotates.",
    epilog=example_of("gyro predict earth --latitude 42.5deg", "--hours 24 --step 3"),
)
def earth(
    latitude: Annotated[
        str | None, _option("--latitude", "Latitude; negative in the south. Default: 42.5 deg, as in the lab sheet.")
    ] = None,
    hours: Annotated[
        float, typer.Option("--hours", metavar="HOURS", min=0.1, max=1000, help="Duration in hours of the clock.")
    ] = 24,
    step: Annotated[
        float, typer.Option("--step", metavar="HOURS", min=0.1, max=1000, help="Hours between two rows.")
    ] = 1,
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Predict the directions of two balanced gyroscopes as the Earth rotates.

    One starts along the Earth's axis, to the pole that is above the horizon. The other starts level, to the east.
    A sidereal hour is 59 min 50.2 s of the clock; each row has both. I_zz and the spin determine how well the ball has
    to be balanced for this.
    """
    from gyrodata.prediction import predict_earth

    numbers = _read(log)
    values = {
        "latitude": numbers.get("--latitude", latitude, "angle", "42.5 deg", "from -90 to 90 degrees"),
        "hours": hours,
        "inertia": numbers.get("--inertia", inertia, "inertia", "4.44e-3 kg m^2", "above zero"),
        "spin": numbers.get("--spin", spin, "rate", "400 rpm", "other than zero"),
    }
    rows = [row * step for row in range(math.ceil(hours / step - 1e-9))]
    times = [3600 * row for row in (*rows, hours)]
    answer = predict_earth(values["latitude"], times, values["inertia"], values["spin"])
    _write(answer, values, numbers, form)


@predict.command(
    short_help="Rotation of a turntable when a wheel is tipped on it.",
    epilog=example_of("gyro predict platform --wheel-spin 200rpm", "--from 0deg --to 90deg"),
)
def platform(
    wheel_inertia: WheelInertiaOption = "0.1 kg m^2",
    wheel_spin: Annotated[
        str, _option("--wheel-spin", "Spin; positive: counterclockwise from above, if the axle points up.")
    ] = "200 rpm",
    platform_inertia: Annotated[
        str, _option("--platform-inertia", "Moment of inertia of platform, person and wheel about the vertical.")
    ] = "3 kg m^2",
    start: Annotated[str, _option("--from", "Angle of the wheel's axle above the horizontal, before.")] = "0 deg",
    end: Annotated[str, _option("--to", "The same angle, after.")] = "90 deg",
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Predict the rotation of a turntable when a spinning wheel is tipped on it.

    The turntable is at rest before. The angular momentum about the vertical does not change.
    """
    from gyrodata.prediction import predict_platform

    values = {
        "wheel_inertia": quantity("--wheel-inertia", wheel_inertia, "inertia", "above zero"),
        "wheel_spin": quantity("--wheel-spin", wheel_spin, "rate"),
        "platform_inertia": quantity("--platform-inertia", platform_inertia, "inertia", "above zero"),
        "from": quantity("--from", start, "angle"),
        "to": quantity("--to", end, "angle"),
    }
    _write(predict_platform(*values.values()), values, _read(None), form)


@predict.command(
    short_help="Torque on your hands when a spinning wheel is turned over.",
    epilog=example_of("gyro predict twist --wheel-spin 200rpm --time 1s"),
)
def twist(
    wheel_inertia: WheelInertiaOption = "0.1 kg m^2",
    wheel_spin: Annotated[
        str, _option("--wheel-spin", "Spin; counterclockwise seen from your right hand is positive.")
    ] = "200 rpm",
    time: Annotated[str, _option("--time", "Time in which the axle is turned over, by half a turn.")] = "1 s",
    handles: Annotated[str, _option("--handles", "Distance between your hands.")] = "40 cm",
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Predict the torque on your hands when a spinning wheel is turned over.

    The axle is level, with one end in each hand, and turns at a steady rate W. This needs a torque I w W, at right
    angles to the motion of the axle.
    """
    from gyrodata.prediction import predict_twist

    values = {
        "wheel_inertia": quantity("--wheel-inertia", wheel_inertia, "inertia", "above zero"),
        "wheel_spin": quantity("--wheel-spin", wheel_spin, "rate"),
        "time": quantity("--time", time, "time", "above zero"),
        "handles": quantity("--handles", handles, "length", "above zero"),
    }
    _write(predict_twist(*values.values()), values, _read(None), form)


@predict.command(
    short_help="Motion of the rod's tip under a steady force.",
    epilog=example_of("gyro predict tip --force 0.5N --length 20cm", "--spin 400rpm"),
)
def tip(
    force: Annotated[str, _option("--force", "Force across the rod, steady in size and direction.")] = "0.1 N",
    length: Annotated[str, _option("--length", "Distance from the centre of the ball to the tip.")] = "20 cm",
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    transverse: TransverseOption = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """Predict the motion of the rod's tip under a steady force.

    The tip moves at right angles to the force, along the torque. For a fast spin w its speed is F L^2/(I_zz w); for a
    slow spin the exact motion is used. Without spin it moves along the force.
    """
    from gyrodata.prediction import predict_tip

    numbers = _read(log)
    values = {
        "force": quantity("--force", force, "force", "above zero"),
        "length": quantity("--length", length, "length", "above zero"),
        "inertia": numbers.get("--inertia", inertia, "inertia", "4.44e-3 kg m^2", "above zero"),
        "spin": numbers.get("--spin", spin, "rate", "400 rpm"),
    }
    numbers.of_log.pop("--transverse", None)
    values["transverse_inertia"] = numbers.transverse(transverse, values["inertia"])
    _write(predict_tip(*values.values()), values, numbers, form)


def _write(
    answer: Precession | Earth | Platform | Twist | Tip, values: dict[str, float], numbers: _Numbers, form: str
) -> None:
    from gyrodata.prediction import prediction_text
    from gyrodata.reporting.data import json_text
    from gyrodata.results import to_json

    answer = replace(answer, options=values, notes=tuple(numbers.notes))
    write_out(json_text(to_json(answer)) if form == "json" else prediction_text(answer))
