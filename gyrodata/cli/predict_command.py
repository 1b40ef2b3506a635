"""``gyro predict``: what theory predicts for given numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.cli.options import Bound, FormatOption, quantity, read
from gyrodata.cli.terminal import Door, refuse, write_out, write_text

if TYPE_CHECKING:
    from gyrodata.physics.prediction import Earth, Platform, Precession, Tip, Twist

predict = typer.Typer(
    cls=Door,
    help="Predict by theory: precession, the rotating Earth, a wheel in your hands, a force "
    "on the tip. Each command "
    "also works without options. --log reads I_zz and the fastest spin from your own log.",
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


Text = Annotated[str, typer.Option(metavar="QUANTITY")]
MayBe = Annotated[str | None, typer.Option(metavar="QUANTITY")]
LogOption = Annotated[str | None, typer.Option("--log", metavar="LOG")]
Hours = Annotated[float, typer.Option(metavar="HOURS", min=0.1, max=1000)]


USUAL = {
    "--inertia": ("inertia", "4.44e-3 kg m^2"),
    "--transverse": ("inertia", ""),
    "--spin": ("rate", "400 rpm"),
    "--mass": ("mass", "60 g"),
    "--position": ("length", "15 cm"),
    "--g": ("acceleration", "9.80665 m/s^2"),
    "--latitude": ("angle", "42.5 deg"),
}
"""Kind and default value of each number that a log can give."""


class _Numbers(Struct):
    """The numbers of a prediction.

    Each number may come from an option, from the log or from a default value.
    """

    name: str
    """Name of the log."""
    of_log: dict[str, float]
    """The log's values by option [SI units]."""
    notes: list[str]
    """Where each number comes from that no option gives."""

    def get(
        self, option: str, text: str | None, bound: Bound = "", usual: str = ""
    ) -> float:
        """Return the value of an option, of the log, or the usual one [SI unit]."""
        from gyrodata.quantities.units import DISPLAY, from_si

        kind, default = USUAL[option]
        usual = usual or default
        if text is not None:
            return quantity(option, text, kind, bound)
        if option not in self.of_log:
            self.notes.append(f'{option} "{usual}", the default value')
            return quantity(option, usual, kind, bound)
        value = self.of_log[option]
        unit = DISPLAY[kind]
        self.notes.append(
            f'{option} "{from_si(value, unit, kind):.6g} {unit}", from {self.name}'
        )
        return value

    def transverse(self, text: str | None, inertia: float, load: float = 0.0) -> float:
        """Return I across the rod [kg*m^2]; `load` is m x^2 of the weight."""
        from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO

        usual = f"{DEFAULT_TRANSVERSE_RATIO * inertia + load:.9g} kg m^2"
        across = self.get("--transverse", text, "above zero", usual)
        if across < inertia / 2:
            refuse("transverse_impossible", across=across)
        return across


def _read(log: str | None) -> _Numbers:
    """Analyse the log, if there is one; a log that is refused ends the command."""
    if log is None:
        return _Numbers("", {}, [])
    from gyrodata.analysis import analyze_readings

    analysis = analyze_readings(read([log]))
    measured = analysis.measurements
    runs = analysis.run_table
    fastest = sorted(
        (i for i, run in enumerate(runs) if not run.left_out),
        key=lambda i: -abs(measured.spin[i]),
    )
    values = {
        "--inertia": analysis.inertia.value,
        "--spin": float(measured.spin[fastest[0]]),
        "--g": measured.g,
    }
    if measured.latitude is not None:
        values["--latitude"] = measured.latitude
    for i in fastest:
        mass = runs[i].mass
        position = runs[i].position
        if mass and position:
            # A column may contain the side of the rod; then it is in the sign of the
            # torque only.
            values |= {
                "--mass": mass,
                "--position": math.copysign(position, runs[i].torque),
            }
            if measured.transverse_inertia is not None and math.isfinite(
                measured.transverse_inertia[i]
            ):
                values["--transverse"] = float(measured.transverse_inertia[i])
            break
    return _Numbers(
        analysis.name,
        values,
        [f"do not rely on I_zz: {doubt.words}" for doubt in analysis.doubts],
    )


@predict.command()
def precession(
    inertia: MayBe = None,
    spin: MayBe = None,
    transverse: MayBe = None,
    mass: MayBe = None,
    position: MayBe = None,
    pitch: Text = "0 deg",
    g: MayBe = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """Predict steady precession, and the motion of a rod that is released or upright.

    There are both roots of eq. (8), and eq. (9). The spin is relative to the frame that
    follows the rod. If there is no steady precession, JSON has null and the reason.
    --log also reads the weight of the log's fastest run.
    """
    from gyrodata import physics
    from gyrodata.physics.prediction import predict_precession

    numbers = _read(log)
    if mass is not None or position is not None:
        # The log has this inertia for its own weight.
        numbers.of_log.pop("--transverse", None)
    values = {
        "inertia": numbers.get("--inertia", inertia, "above zero"),
        "spin": numbers.get("--spin", spin),
        "pitch": quantity("--pitch", pitch, "angle", "below 90 degrees"),
        "mass": numbers.get("--mass", mass, "zero or above"),
        "position": numbers.get("--position", position),
        "g": numbers.get("--g", g, "above zero"),
    }
    values["torque"] = float(
        physics.torque(values["mass"], values["position"], values["g"])
    )
    load = values["mass"] * values["position"] ** 2
    values["transverse_inertia"] = numbers.transverse(
        transverse, values["inertia"], load
    )
    names = ("torque", "spin", "inertia", "transverse_inertia", "pitch")
    _write(predict_precession(*(values[name] for name in names)), values, numbers, form)


@predict.command()
def earth(
    latitude: MayBe = None,
    hours: Hours = 24,
    step: Hours = 1,
    inertia: MayBe = None,
    spin: MayBe = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """Predict the directions of two balanced gyroscopes as the Earth rotates.

    One starts along the Earth's axis, to the pole that is above the horizon. The other
    starts level, to the east. A sidereal hour is 59 min 50.2 s of the clock; each row
    has both. I_zz and the spin determine how well the ball has to be balanced for this.
    """
    from gyrodata.physics.prediction import predict_earth

    numbers = _read(log)
    values = {
        "latitude": numbers.get("--latitude", latitude, "from -90 to 90 degrees"),
        "hours": hours,
        "inertia": numbers.get("--inertia", inertia, "above zero"),
        "spin": numbers.get("--spin", spin, "other than zero"),
    }
    rows = [row * step for row in range(math.ceil(hours / step - 1e-9))]
    times = [3600 * row for row in (*rows, hours)]
    answer = predict_earth(values["latitude"], times, values["inertia"], values["spin"])
    _write(answer, values, numbers, form)


@predict.command()
def platform(
    wheel_inertia: Text = "0.1 kg m^2",
    wheel_spin: Text = "200 rpm",
    platform_inertia: Text = "3 kg m^2",
    start: Annotated[str, typer.Option("--from", metavar="QUANTITY")] = "0 deg",
    end: Annotated[str, typer.Option("--to", metavar="QUANTITY")] = "90 deg",
    form: FormatOption = "text",
) -> None:
    """Predict the rotation of a turntable when a spinning wheel is tipped on it.

    The turntable is at rest before. The angular momentum about the vertical does not
    change.
    """
    from gyrodata.physics.prediction import predict_platform

    values = {
        "wheel_inertia": quantity(
            "--wheel-inertia", wheel_inertia, "inertia", "above zero"
        ),
        "wheel_spin": quantity("--wheel-spin", wheel_spin, "rate"),
        "platform_inertia": quantity(
            "--platform-inertia", platform_inertia, "inertia", "above zero"
        ),
        "from": quantity("--from", start, "angle"),
        "to": quantity("--to", end, "angle"),
    }
    _write(predict_platform(*values.values()), values, _read(None), form)


@predict.command()
def twist(
    wheel_inertia: Text = "0.1 kg m^2",
    wheel_spin: Text = "200 rpm",
    time: Text = "1 s",
    handles: Text = "40 cm",
    form: FormatOption = "text",
) -> None:
    """Predict the torque on your hands when a spinning wheel is turned over.

    The axle is level, with one end in each hand, and turns at a steady rate W. This
    needs a torque I w W, at right angles to the motion of the axle.
    """
    from gyrodata.physics.prediction import predict_twist

    values = {
        "wheel_inertia": quantity(
            "--wheel-inertia", wheel_inertia, "inertia", "above zero"
        ),
        "wheel_spin": quantity("--wheel-spin", wheel_spin, "rate"),
        "time": quantity("--time", time, "time", "above zero"),
        "handles": quantity("--handles", handles, "length", "above zero"),
    }
    _write(predict_twist(*values.values()), values, _read(None), form)


@predict.command()
def tip(
    force: Text = "0.1 N",
    length: Text = "20 cm",
    inertia: MayBe = None,
    spin: MayBe = None,
    transverse: MayBe = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """Predict the motion of the rod's tip under a steady force.

    The tip moves at right angles to the force, along the torque. For a fast spin w its
    speed is F L^2/(I_zz w); for a slow spin the exact motion is used. Without spin it
    moves along the force.
    """
    from gyrodata.physics.prediction import predict_tip

    numbers = _read(log)
    values = {
        "force": quantity("--force", force, "force", "above zero"),
        "length": quantity("--length", length, "length", "above zero"),
        "inertia": numbers.get("--inertia", inertia, "above zero"),
        "spin": numbers.get("--spin", spin),
    }
    numbers.of_log.pop("--transverse", None)
    values["transverse_inertia"] = numbers.transverse(transverse, values["inertia"])
    _write(predict_tip(*values.values()), values, numbers, form)


def _write(
    answer: Precession | Earth | Platform | Twist | Tip,
    values: dict[str, float],
    numbers: _Numbers,
    form: str,
) -> None:
    from gyrodata.physics.prediction import prediction_text
    from gyrodata.reporting.data import json_text
    from gyrodata.results import to_json

    answer = replace(answer, options=values, notes=tuple(numbers.notes))
    if form == "json":
        write_out(json_text(to_json(answer)))
    else:
        write_text(prediction_text(answer))
