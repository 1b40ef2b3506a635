"""``gyro predict``: what theory says for given numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from gyrodata.cli.options import PlainFormat, example_of, quantity
from gyrodata.cli.terminal import refuse, write_folder, write_out
from gyrodata.diagnostics import OPTION_IS_NO_QUANTITY, OPTION_NUMBER_IMPOSSIBLE, TORQUE_MISSING_OR_TWICE

predict = typer.Typer(
    help="Say what theory predicts: precession, the turning Earth, a tipped wheel, a force on the tip.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

_MOST_ROWS = 10_000


def _option(name: str, text: str) -> Any:
    return typer.Option(name, metavar="QUANTITY", help=text)


FormatOption = Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")]
InertiaOption = Annotated[str, _option("--inertia", 'I_zz about the rod, such as "4.44e-3 kg m^2".')]
SpinOption = Annotated[
    str, _option("--spin", 'Spin, such as "400 rpm"; counterclockwise seen from the tip is positive.')
]


@predict.command(
    short_help="Steady precession, and a rod that is let go or upright.",
    epilog=example_of(
        'gyro predict precession --inertia "4.44e-3 kg m^2" --mass 60g',
        "--position 15cm --spin 400rpm --pitch 10deg",
    ),
)
def precession(
    inertia: InertiaOption,
    spin: SpinOption,
    transverse: Annotated[
        str | None,
        _option("--transverse", "I about an axis across the rod through the centre, the weight included. "
                "Default: 1.3 I_zz, plus m x^2 of --mass at --position."),
    ] = None,
    torque: Annotated[str | None, _option("--torque", 'Torque with the rod level, such as "0.0588 N*m".')] = None,
    mass: Annotated[str | None, _option("--mass", 'Mass of the weight, such as "60 g".')] = None,
    position: Annotated[str | None, _option("--position", 'Position on the rod, such as "15 cm".')] = None,
    pitch: Annotated[str, _option("--pitch", 'Angle of the rod above the horizontal, such as "10 deg".')] = "0 deg",
    g: Annotated[str | None, _option("--g", 'Gravity, such as "9.803 m/s^2". Default: 9.80665 m/s^2.')] = None,
    form: FormatOption = "text",
) -> None:  # fmt: skip
    """Steady precession, its least spin, and what a rod does that is let go or upright.

    Both roots of eq. (8), and eq. (9). The spin is that relative to the frame that follows the rod. Where there
    is no steady precession, JSON has null and the reason.
    """
    options: dict[str, Any] = {
        "inertia": quantity("--inertia", inertia, "inertia", positive=True),
        "spin": quantity("--spin", spin, "rate"),
        "pitch": quantity("--pitch", pitch, "angle"),
        **_load(torque, mass, position, g),
    }
    if abs(options["pitch"]) >= math.pi / 2:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--pitch "{pitch}" is not between -90 and 90 degrees',
            "take a smaller --pitch; what an upright rod does is in every answer",
        )
    notes = _take_defaults(options, transverse)
    from gyrodata.prediction import predict_precession

    names = ("torque", "spin", "inertia", "transverse_inertia", "pitch")
    _tell("precession", options, notes, predict_precession(*(options[name] for name in names)), form)


def _load(torque: str | None, mass: str | None, position: str | None, g: str | None) -> dict[str, float | None]:
    """Torque [N*m], and what it follows from, None where that was not asked."""
    hint = "give --torque, or --mass and --position"
    if torque is not None:
        if mass is not None or position is not None:
            refuse(TORQUE_MISSING_OR_TWICE, "the torque is given twice", f"{hint}, not both")
        load = quantity("--torque", torque, "torque")
        return {"torque": load, "mass": None, "position": None, "g": None}
    if mass is None or position is None:
        lacks = "--position" if mass is not None else "--mass" if position is not None else ""
        refuse(TORQUE_MISSING_OR_TWICE, f"{lacks} is not given" if lacks else "no torque is given", hint)
    weight = quantity("--mass", mass, "mass")
    if weight < 0:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--mass "{mass}" is below zero',
            "a weight on the other side has a negative --position",
        )
    arm = quantity("--position", position, "length")
    fall = None if g is None else quantity("--g", g, "acceleration", positive=True)
    return {"torque": None, "mass": weight, "position": arm, "g": fall}


def _take_defaults(options: dict[str, Any], transverse: str | None) -> list[str]:
    """Complete the numbers by what was not given, and say which."""
    from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
    from gyrodata.physics import STANDARD_GRAVITY
    from gyrodata.physics import torque as torque_of

    notes = []
    mass, position, own = options["mass"], options["position"], options["inertia"]
    if mass is not None:
        if options["g"] is None:
            options["g"] = STANDARD_GRAVITY
            notes.append(f"g = {STANDARD_GRAVITY} m/s^2")
        options["torque"] = float(torque_of(mass, position, options["g"]))
    if transverse is None:
        load, weight = (0.0, "") if mass is None else (mass * position**2, " + m x^2")
        options["transverse_inertia"] = across = DEFAULT_TRANSVERSE_RATIO * own + load
        notes.append(f"I = {DEFAULT_TRANSVERSE_RATIO} I_zz{weight} = {across:.4g} kg*m^2 (--transverse)")
    else:
        options["transverse_inertia"] = across = quantity("--transverse", transverse, "inertia", positive=True)
        if across < own / 2:
            refuse(
                OPTION_NUMBER_IMPOSSIBLE,
                f'--transverse "{transverse}" is below I_zz/2, which no body has',
                "I is about an axis across the rod, and at least I_zz/2; or leave --transverse out",
            )
    return notes


@predict.command(
    short_help="Where balanced gyroscopes point as the Earth turns.",
    epilog=example_of("gyro predict earth --latitude 42.5deg --hours 24 --step 3"),
)
def earth(
    latitude: Annotated[str, _option("--latitude", 'Latitude, such as "42.5 deg"; negative in the south.')],
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
    form: FormatOption = "text",
) -> None:
    """Where two balanced gyroscopes point as the Earth turns.

    One is started along the Earth's axis, to the north, the other level, to the east. A sidereal hour is 59 min
    50.2 s of the clock; each row has both. The last row is that of --hours.
    """
    at = quantity("--latitude", latitude, "angle")
    if abs(at) > math.pi / 2:
        refuse(
            OPTION_NUMBER_IMPOSSIBLE,
            f'--latitude "{latitude}" is not between -90 and 90 degrees',
            "write 0 to 90 deg, in the south with a minus sign",
        )
    times = _times(_hours("--hours", hours), _hours("--step", step), sidereal)
    from gyrodata.prediction import predict_earth

    options = {"latitude": at, "hours": times[-1] / 3600, "sidereal": sidereal}
    answer = predict_earth(at, times)
    if out is not None:
        from gyrodata.plotting import render_earth

        write_folder(out, {"earth.png": render_earth(at, times)})
    _tell("earth", options, [], answer, form)


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
        'gyro predict platform --wheel-inertia "0.1 kg m^2"',
        '--wheel-spin 200rpm --platform-inertia "4 kg m^2"',
        "--from 0deg --to 90deg",
    ),
)
def platform(
    wheel_inertia: Annotated[str, _option("--wheel-inertia", 'Of the wheel about its axle, such as "0.1 kg m^2".')],
    wheel_spin: Annotated[str, _option("--wheel-spin", 'Spin of the wheel, such as "200 rpm".')],
    platform_inertia: Annotated[
        str, _option("--platform-inertia", "Of platform, person and wheel about the vertical.")
    ],
    start: Annotated[str, _option("--from", "Angle of the wheel's axle above the horizontal, before.")] = "0 deg",
    end: Annotated[str, _option("--to", "The same angle, after.")] = "90 deg",
    form: FormatOption = "text",
) -> None:
    """How fast a turntable turns when a spinning wheel is tipped on it.

    It is at rest before; the angular momentum about the vertical stays the same.
    """
    options = {
        "wheel_inertia": quantity("--wheel-inertia", wheel_inertia, "inertia", positive=True),
        "wheel_spin": quantity("--wheel-spin", wheel_spin, "rate"),
        "platform_inertia": quantity("--platform-inertia", platform_inertia, "inertia", positive=True),
        "from": quantity("--from", start, "angle"),
        "to": quantity("--to", end, "angle"),
    }
    from gyrodata.prediction import predict_platform

    _tell("platform", options, [], predict_platform(*options.values()), form)


@predict.command(
    short_help="How the rod's tip yields to a steady force.",
    epilog=example_of(
        "gyro predict tip --force 0.5N --length 20cm",
        '--inertia "4.44e-3 kg m^2" --spin 400rpm',
    ),
)
def tip(
    force: Annotated[str, _option("--force", 'Across the rod, such as "0.5 N".')],
    length: Annotated[str, _option("--length", 'From the centre of the ball to the tip, such as "20 cm".')],
    inertia: InertiaOption,
    spin: SpinOption,
    form: FormatOption = "text",
) -> None:
    """How the rod's tip yields to a steady force.

    Along the torque, with v = F L^2/(I_zz w).
    """
    options = {
        "force": quantity("--force", force, "force", positive=True),
        "length": quantity("--length", length, "length", positive=True),
        "inertia": quantity("--inertia", inertia, "inertia", positive=True),
        "spin": quantity("--spin", spin, "rate", nonzero=True),
    }
    from gyrodata.prediction import predict_tip

    _tell("tip", options, [], predict_tip(*options.values()), form)


def _tell(
    name: str, options: Mapping[str, Any], notes: Sequence[str], answer: Mapping[str, Any], form: PlainFormat
) -> None:
    from gyrodata.prediction import document, prediction_text

    told = document(name, options, notes, answer)
    if form == "text":
        write_out(prediction_text(told))
        return
    from gyrodata.reporting import json_text

    write_out(json_text(told))
