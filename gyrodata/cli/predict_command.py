"""``gyro predict``: what theory says for given numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from msgspec import Struct

from gyrodata.cli.options import PlainFormat, example_of, quantity
from gyrodata.cli.terminal import STDIN, name_of, refuse, source_of, write_out
from gyrodata.diagnostics import (
    OPTION_IS_NO_QUANTITY,
    OPTION_NOR_LOG_GIVEN,
    OPTION_NUMBER_IMPOSSIBLE,
    REPORT_CANNOT_BE_WRITTEN,
    TORQUE_MISSING_OR_TWICE,
)
from gyrodata.disk import telling, write_folder

if TYPE_CHECKING:
    from gyrodata.prediction import Answer

predict = typer.Typer(
    help="Say what theory predicts: precession, the turning Earth, a wheel in your hands, a force on the tip. With "
    "--log, for the ball and the fastest spin of your own log.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

_MOST_ROWS = 10_000

_LAB_SHEET = math.radians(42.5)
"""Latitude of the lab sheet [rad]."""


def _option(name: str, text: str) -> Any:
    return typer.Option(name, metavar="QUANTITY", help=text)


FormatOption = Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")]
LogOption = Annotated[
    str | None,
    typer.Option("--log", metavar="LOG", help="Take I_zz and the fastest spin from this log, where no option gives "
                 "them; - is standard input."),
]  # fmt: skip
InertiaOption = Annotated[str | None, _option("--inertia", 'I_zz about the rod, such as "4.44e-3 kg m^2".')]
SpinOption = Annotated[
    str | None, _option("--spin", 'Spin, such as "400 rpm"; counterclockwise seen from the tip is positive.')
]
TransverseOption = Annotated[
    str | None,
    _option("--transverse", "I about an axis across the rod through the centre, with any weight on it. Default: "
            "1.3 I_zz, plus m x^2 of a weight."),
]  # fmt: skip
WheelInertiaOption = Annotated[
    str | None, _option("--wheel-inertia", 'Of the wheel about its axle, such as "0.1 kg m^2".')
]


class _Lab(Struct, frozen=True):
    """The values that a prediction takes from a log, and its default values."""

    notes: list[str]
    name: str = ""
    inertia: float | None = None
    doubt: float = 0.0
    """Relative uncertainty of I_zz [1]."""
    spin: float | None = None
    latitude: float | None = None
    load: Mapping[str, float | None] | None = None
    """Of the fastest run that has one: torque, mass, position and g, and "transverse_inertia" if the log tells it."""

    def given(self, option: str, text: str | None, kind: str, **limits: bool) -> float:
        """Give an option's number, else the log's: I_zz or a spin."""
        if text is not None:
            return quantity(option, text, kind, **limits)
        value = self.inertia if kind == "inertia" else self.spin
        if value is None:
            refuse(OPTION_NOR_LOG_GIVEN, f"{option} is not given", f"give {option}, or a log to take it from: --log "
                   "data.csv")  # fmt: skip
        from gyrodata.physics import RPM

        told = f"I_zz = {value:.4g} kg·m², u = {100 * self.doubt:.2g} %, of"
        words = told if kind == "inertia" else f"{value / RPM:.4g} rpm, the fastest spin of"
        self.notes.append(f"{words} {self.name} ({option})")
        return value


def _read(log: str | None) -> _Lab:
    """Analyse the log, if there is one; a log that is refused ends here, in the words of ``gyro analyze``."""
    if log is None:
        return _Lab([])
    from gyrodata.analysis import analyze

    name = name_of(log, STDIN)
    found = analyze(source_of(log, name)["source"], name=name)
    measured = found.measurements
    kept = [i for i, run in enumerate(found.run_table) if not run.left_out]
    fastest = sorted(kept, key=lambda i: -abs(measured.spin[i]))
    load: dict[str, float | None] = {}
    if loaded := [i for i in fastest if measured.torque[i]]:
        run = found.run_table[loaded[0]]
        # The side that the weight is on may be in a column of its own.
        arm = None if run.position is None else math.copysign(run.position, run.torque)
        load = {"torque": run.torque, "mass": run.mass, "position": arm, "g": measured.g}
        if measured.transverse_inertia is not None and math.isfinite(measured.transverse_inertia[loaded[0]]):
            load["transverse_inertia"] = float(measured.transverse_inertia[loaded[0]])
    return _Lab(
        notes=[f"do not rely on I_zz: {doubt.words}" for doubt in found.doubts],
        name=name,
        inertia=found.inertia.value,
        doubt=found.inertia.relative_u or 0.0,
        spin=float(measured.spin[fastest[0]]),
        latitude=measured.latitude,
        load=load,
    )


@predict.command(
    short_help="Steady precession, and a rod that is let go or upright.",
    epilog=example_of(
        "gyro predict precession --mass 60g",
        '--inertia "4.44e-3 kg m^2" --position 15cm',
        "--spin 400rpm --pitch 10deg",
    ),
)
def precession(
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    transverse: TransverseOption = None,
    torque: Annotated[str | None, _option("--torque", 'Torque with the rod level, such as "0.0588 N*m".')] = None,
    mass: Annotated[str | None, _option("--mass", 'Mass of the weight, such as "60 g".')] = None,
    position: Annotated[str | None, _option("--position", 'Position on the rod, such as "15 cm".')] = None,
    pitch: Annotated[str, _option("--pitch", 'Angle of the rod above the horizontal, such as "10 deg".')] = "0 deg",
    g: Annotated[str | None, _option("--g", 'Gravity, such as "9.803 m/s^2". Default: 9.80665 m/s^2.')] = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Steady precession, its least spin, and what a rod does that is let go or upright.

    Both roots of eq. (8), and eq. (9). The spin is that relative to the frame that follows the rod. Where there
    is no steady precession, JSON has null and the reason. With --log alone the weight is that of the log's
    fastest run.
    """
    lab = _read(log)
    options: dict[str, Any] = {
        "inertia": lab.given("--inertia", inertia, "inertia", positive=True),
        "spin": lab.given("--spin", spin, "rate"),
        "pitch": quantity("--pitch", pitch, "angle"),
    }
    options |= _load(torque, mass, position, g, lab)
    if abs(options["pitch"]) >= math.pi / 2:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--pitch "{pitch}" is not between -90 and 90 degrees',
            "take a smaller --pitch; what an upright rod does is in every answer",
        )
    options["transverse_inertia"] = _across(transverse, options, lab.notes)
    from gyrodata.prediction import predict_precession

    names = ("torque", "spin", "inertia", "transverse_inertia", "pitch")
    _tell("precession", options, lab.notes, predict_precession(*(options[name] for name in names)), form)


def _load(torque: str | None, mass: str | None, position: str | None, g: str | None, lab: _Lab) -> dict[str, Any]:
    """Torque [N*m], and what it follows from, None if that was not given; the log's if no option gives one."""
    from gyrodata import physics

    hint = "give --torque, or --mass and --position"
    if torque is not None:
        if mass is not None or position is not None:
            refuse(TORQUE_MISSING_OR_TWICE, "the torque is given twice", f"{hint}, not both")
        return {"torque": quantity("--torque", torque, "torque"), "mass": None, "position": None, "g": None}
    if mass is None and position is None and lab.load:
        lab.notes.append(f"torque = {lab.load['torque']:.4g} N·m, that of the fastest run with a weight (--torque)")
        return dict(lab.load)
    if mass is None or position is None:
        lacks = "--position" if mass is not None else "--mass" if position is not None else ""
        refuse(TORQUE_MISSING_OR_TWICE, f"{lacks} is not given" if lacks else "no torque is given", hint)
    weight, arm = quantity("--mass", mass, "mass"), quantity("--position", position, "length")
    if weight < 0:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--mass "{mass}" is below zero',
            "a weight on the other side has a negative --position",
        )
    fall = (lab.load or {}).get("g") if g is None else quantity("--g", g, "acceleration", positive=True)
    if fall is None:
        fall = physics.STANDARD_GRAVITY
        lab.notes.append(f"g = {fall} m/s²")
    return {"torque": float(physics.torque(weight, arm, fall)), "mass": weight, "position": arm, "g": fall}


def _across(text: str | None, options: Mapping[str, Any], notes: list[str]) -> float:
    """Transverse inertia [kg*m^2]: by the option, by the log, or by default, which is noted."""
    from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO

    own, mass = options["inertia"], options.get("mass")
    if text is None:
        told = options.get("transverse_inertia")
        load, weight = (0.0, "") if mass is None else (mass * options["position"] ** 2, " + m x^2")
        across = float(DEFAULT_TRANSVERSE_RATIO * own + load if told is None else told)
        words = f"{DEFAULT_TRANSVERSE_RATIO} I_zz{weight} = " if told is None else ""
        notes.append(f"I = {words}{across:.4g} kg·m² (--transverse)")
        return across
    across = quantity("--transverse", text, "inertia", positive=True)
    if across < own / 2:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--transverse "{text}" is below I_zz/2, which no body has',
            "I is about an axis across the rod, and at least I_zz/2; or leave --transverse out",
        )
    return across


@predict.command(
    short_help="Where balanced gyroscopes point as the Earth turns.",
    epilog=example_of("gyro predict earth --latitude 42.5deg", "--hours 24 --step 3"),
)
def earth(
    latitude: Annotated[
        str | None,
        _option("--latitude", 'Latitude, such as "42.5 deg"; negative in the south. Default: that of the log, else '
                "42.5 deg, as in the lab sheet."),
    ] = None,
    hours: Annotated[
        str, typer.Option("--hours", metavar="HOURS", help="How long: hours of the clock (solar), not sidereal ones.")
    ] = "24",
    step: Annotated[str, typer.Option("--step", metavar="HOURS", help="Hours from row to row.")] = "1",
    sidereal: Annotated[
        bool, typer.Option("--sidereal", help="Count --hours and --step in sidereal hours, 24 to a turn of the Earth.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for a figure, earth.png; made if it is not there.")
    ] = None,
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Where two balanced gyroscopes point as the Earth turns.

    One is started along the Earth's axis, to the pole that is above the horizon, the other level, to the east.
    A sidereal hour is 59 min 50.2 s of the clock; each row has both. The last row is that of --hours. With I_zz and
    spin: how well the ball has to be balanced for it.
    """
    lab = _read(log)
    at = _LAB_SHEET if lab.latitude is None else lab.latitude
    if latitude is None:
        lab.notes.append(f"latitude = {math.degrees(at):.4g} deg (--latitude)")
    else:
        at = quantity("--latitude", latitude, "angle")
    if abs(at) > math.pi / 2:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--latitude "{latitude}" is not between -90 and 90 degrees',
            "write 0 to 90 deg, in the south with a minus sign",
        )
    times = _times(_hours("--hours", hours), _hours("--step", step), sidereal)
    from gyrodata.prediction import predict_earth

    body: dict[str, float | None] = {"inertia": None, "spin": None}
    if inertia is not None or spin is not None or log is not None:
        body["inertia"] = lab.given("--inertia", inertia, "inertia", positive=True)
        body["spin"] = lab.given("--spin", spin, "rate", nonzero=True)
    options = {"latitude": at, "hours": times[-1] / 3600, "sidereal": sidereal, **body}
    answer = predict_earth(at, times, **body)
    if out is not None:
        from gyrodata.plotting import render_earth

        with telling(out, REPORT_CANNOT_BE_WRITTEN):
            write_folder(out, {"earth.png": render_earth(at, times)})
    _tell("earth", options, lab.notes, answer, form)


def _hours(option: str, text: str) -> float:
    """Read a number of hours above zero."""
    try:
        value = float(text)
    except ValueError:
        refuse(OPTION_IS_NO_QUANTITY, f'{option} "{text[:40]}" is not a number of hours', f"write it like {option} 24")
    if not 0 < value <= 1e6:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'{option} "{text[:40]}" is not a number of hours above zero and up to a million',
            f"write it like {option} 24",
        )
    return value


def _times(hours: float, step: float, sidereal: bool) -> list[float]:
    """Clock times of the rows [s]: every step from 0, and the end."""
    from gyrodata.physics import SIDEREAL_DAY

    hour = SIDEREAL_DAY / 24 if sidereal else 3600.0
    count = math.floor(hours / step * (1 + 1e-12))
    if count > _MOST_ROWS:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f"that would be {count} rows",
            f"give a longer --step: {_MOST_ROWS} rows are the most",
        )
    rows = [k * step for k in range(count + 1) if hours - k * step > 1e-9 * hours]
    return [row * hour for row in (*rows, hours)]


@predict.command(
    short_help="How fast a turntable turns when a wheel is tipped on it.",
    epilog=example_of(
        "gyro predict platform --wheel-spin 200rpm",
        '--wheel-inertia "0.1 kg m^2"',
        '--platform-inertia "4 kg m^2"',
        "--from 0deg --to 90deg",
    ),
)
def platform(
    wheel_inertia: WheelInertiaOption = None,
    wheel_spin: Annotated[str | None, _option("--wheel-spin", 'Spin of the wheel, such as "200 rpm".')] = None,
    platform_inertia: Annotated[
        str, _option("--platform-inertia", "Of platform, person and wheel about the vertical.")
    ] = "3 kg m^2",
    start: Annotated[str, _option("--from", "Angle of the wheel's axle above the horizontal, before.")] = "0 deg",
    end: Annotated[str, _option("--to", "The same angle, after.")] = "90 deg",
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """How fast a turntable turns when a spinning wheel is tipped on it.

    It is at rest before; the angular momentum about the vertical stays the same. With --log the wheel is the
    ball of the log.
    """
    lab = _read(log)
    options = {
        "wheel_inertia": lab.given("--wheel-inertia", wheel_inertia, "inertia", positive=True),
        "wheel_spin": lab.given("--wheel-spin", wheel_spin, "rate"),
        "platform_inertia": quantity("--platform-inertia", platform_inertia, "inertia", positive=True),
        "from": quantity("--from", start, "angle"),
        "to": quantity("--to", end, "angle"),
    }
    from gyrodata.prediction import predict_platform

    _note_ball(lab, wheel_inertia)
    _tell("platform", options, lab.notes, predict_platform(*options.values()), form)


@predict.command(
    short_help="Predict the torque on your hands when a spinning wheel is turned over.",
    epilog=example_of("gyro predict twist --wheel-spin 200rpm", '--wheel-inertia "0.1 kg m^2"'),
)
def twist(
    wheel_inertia: WheelInertiaOption = None,
    wheel_spin: Annotated[
        str | None,
        _option("--wheel-spin", 'Spin of the wheel, such as "200 rpm"; counterclockwise seen from your right hand is '
                "positive."),
    ] = None,
    time: Annotated[str, _option("--time", "In which the axle is turned over, by half a turn.")] = "1 s",
    handles: Annotated[str, _option("--handles", "Distance between your hands.")] = "40 cm",
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Predict the torque on your hands when a spinning wheel is turned over.

    The axle is level, one end in each hand, and turns at a steady rate W: a torque I w W, at right angles to the
    way that it goes. With --log the wheel is the ball of the log.
    """
    lab = _read(log)
    options = {
        "wheel_inertia": lab.given("--wheel-inertia", wheel_inertia, "inertia", positive=True),
        "wheel_spin": lab.given("--wheel-spin", wheel_spin, "rate"),
        "time": quantity("--time", time, "time", positive=True),
        "handles": quantity("--handles", handles, "length", positive=True),
    }
    from gyrodata.prediction import predict_twist

    _note_ball(lab, wheel_inertia)
    _tell("twist", options, lab.notes, predict_twist(*options.values()), form)


@predict.command(
    short_help="How the rod's tip yields to a steady force.",
    epilog=example_of(
        "gyro predict tip --force 0.5N --length 20cm",
        '--inertia "4.44e-3 kg m^2" --spin 400rpm',
    ),
)
def tip(
    force: Annotated[str, _option("--force", "Across the rod, steady in size and direction.")] = "0.1 N",
    length: Annotated[str, _option("--length", "From the centre of the ball to the tip.")] = "20 cm",
    inertia: InertiaOption = None,
    spin: SpinOption = None,
    transverse: TransverseOption = None,
    log: LogOption = None,
    form: FormatOption = "text",
) -> None:
    """How the rod's tip yields to a steady force.

    At right angles to it, along the torque: for a fast spin w at F L^2/(I_zz w), for a slow one by the exact
    motion; without spin, along the force.
    """
    lab = _read(log)
    options = {
        "force": quantity("--force", force, "force", positive=True),
        "length": quantity("--length", length, "length", positive=True),
        "inertia": lab.given("--inertia", inertia, "inertia", positive=True),
        "spin": lab.given("--spin", spin, "rate"),
    }
    options["transverse_inertia"] = _across(transverse, options, lab.notes)
    from gyrodata.prediction import predict_tip

    _tell("tip", options, lab.notes, predict_tip(*options.values()), form)


def _note_ball(lab: _Lab, wheel_inertia: str | None) -> None:
    """Say that the log's ball is not the wheel that somebody held."""
    if wheel_inertia is None:
        lab.notes.append("so the wheel is the ball of the log; for the wheel that you held give its own two")


def _tell(name: str, options: Mapping[str, Any], notes: Sequence[str], answer: Answer, form: PlainFormat) -> None:
    from gyrodata.prediction import document, prediction_text

    if form == "text":
        write_out(prediction_text(options, notes, answer))
        return
    from gyrodata.reporting.data import json_text

    write_out(json_text(document(name, options, notes, answer)))
