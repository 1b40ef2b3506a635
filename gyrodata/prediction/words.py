"""Predictions as text for people: rpm, seconds and degrees, with the SI unit beside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from gyrodata.prediction.answers import RPM


def prediction_text(document: Mapping[str, Any]) -> str:
    """Write a prediction as text.

    Parameters
    ----------
    document : mapping
        As `document` gives it.

    Returns
    -------
    str
        Ends with a line end.
    """
    writers = {"precession": _precession, "earth": _earth, "platform": _platform, "tip": _tip}
    lines = writers[document["prediction"]](document)
    if document["notes"]:
        lines += ["", "taken by default:", *(f"  {note}" for note in document["notes"])]
    return "\n".join(lines) + "\n"


def _rate(value: float) -> str:
    return f"{value / RPM:.4g} rpm ({value:.4g} rad/s)"


def _angle(value: float) -> str:
    return f"{math.degrees(value):.3g}° ({value:.3g} rad)"


def _line(label: str, text: str) -> str:
    return f"  {label:<16}{text}"


def _precession(told: Mapping[str, Any]) -> list[str]:
    options = told["options"]
    pitch, spin = f"{math.degrees(options['pitch']):.4g}°", _rate(options["spin"])
    lines = [f"steady precession at pitch {pitch}, spin {spin}, torque {options['torque']:.4g} N*m"]
    if told["slow"] is not None:
        turn = f", one turn in {told['period']:.4g} s" if told["period"] else ""
        lines.append(_line("slow, eq. (8)", _rate(told["slow"]) + turn))
    if told["fast"] is not None:
        lines.append(_line("fast, eq. (8)", _rate(told["fast"])))
    if told["horizontal"] is not None:
        lines.append(_line("level, eq. (9)", _rate(told["horizontal"])))
    lines.append(_line("least spin", f"{_least(told['critical_spin'])} for steady precession at this pitch"))
    lines += _lacking(told)
    return [*lines, "", *_released(told["released"]), "", *_sleeping(told["sleeping"])]


def _released(told: Mapping[str, Any]) -> list[str]:
    lines = ["let go from rest"]
    if told["mean_rate"] is not None:
        lines.append(_line("mean rate", _rate(told["mean_rate"])))
    sag = f"{_angle(told['sag'])} on average, " if told["sag"] is not None else ""
    lines.append(_line("sags by", f"{sag}{_angle(told['greatest_sag'])} at most"))
    if told["nutation_rate"] is not None:
        lines.append(_line("nutates at", _rate(told["nutation_rate"])))
        lines.append(_line("click error", f"up to {told['click_error_s']:.2g} s, by the phase of the nutation"))
    return [*lines, *_lacking(told)]


def _lacking(told: Mapping[str, Any]) -> list[str]:
    """Say what is None, and why."""
    return [
        f"  no {clause.replace('click_error_s', 'click error').replace('_', ' ')}"
        for clause in told["reason"].split("; ")
        if clause
    ]


def _sleeping(told: Mapping[str, Any]) -> list[str]:
    lines = ["rod upright, at this spin"]
    if told["stable"]:
        lines.append(_line("stays", "a small tilt does not grow"))
    elif told["growth_rate"]:
        lines.append(_line("falls", f"a small tilt grows e-fold in {1 / told['growth_rate']:.3g} s"))
    else:
        lines.append(_line("drifts", "nothing holds it"))
    return [*lines, _line("least spin", f"{_least(told['critical_spin'])} to stay")]


def _least(spin: float) -> str:
    return _rate(spin) if spin else "any"


def _earth(told: Mapping[str, Any]) -> list[str]:
    latitude = math.degrees(told["options"]["latitude"])
    lines = [
        f"balanced gyroscopes at latitude {latitude:.4g}°, from the ground, which turns under them",
        "  north: started along the Earth's axis; east: started level. Azimuth is from north through east.",
        "",
        f"  {'hours':>8}{'sidereal':>10}{'north: azimuth':>17}{'altitude':>10}{'east: azimuth':>16}{'altitude':>10}",
    ]
    for north, east in zip(told["north"], told["east"], strict=True):
        cells = f"  {north['hours']:>8.4f}{north['sidereal_hours']:>10.4f}"
        cells += f"{_bearing(north):>17}{_height(north):>10}{_bearing(east):>16}{_height(east):>10}"
        lines.append(cells)
    return lines


def _bearing(row: Mapping[str, Any]) -> str:
    return "-" if row["azimuth_deg"] is None else f"{round(row['azimuth_deg'], 2) % 360:.2f}°"


def _height(row: Mapping[str, Any]) -> str:
    # No "-0.00".
    return f"{round(row['altitude_deg'], 2) + 0.0:.2f}°"


def _platform(told: Mapping[str, Any]) -> list[str]:
    start, end = (math.degrees(told["options"][name]) for name in ("from", "to"))
    lines = [f"axle tipped from {start:.4g}° to {end:.4g}° above the horizontal, the platform at rest before"]
    if told["period"]:
        sense = "in" if told["rate"] * told["options"]["wheel_spin"] > 0 else "against"
        lines.append(_line("platform", f"{_rate(abs(told['rate']))}, one turn in {told['period']:.4g} s"))
        lines.append(_line("sense", f"{sense} that of the wheel when its axle points up"))
    else:
        lines.append(_line("platform", "stays at rest"))
    lines.append("")
    lines.append("angular momentum about the vertical, which stays the same [kg*m^2/s]")
    lines.append(_line("before", f"wheel {told['momentum_before']:.4g}"))
    after = f"wheel {told['momentum_after']:.4g}, platform {told['momentum_platform']:.4g}"
    return [*lines, _line("after", after)]


def _tip(told: Mapping[str, Any]) -> list[str]:
    speed, options = told["speed"], told["options"]
    return [
        f"a force of {options['force']:.4g} N across the rod, {100 * options['length']:.4g} cm from the centre",
        _line("tip", f"{100 * speed:.4g} cm/s ({speed:.4g} m/s)"),
        _line("direction", told["direction"]),
        _line("rod turns at", _rate(told["turning_rate"])),
        _line("torque", f"{told['torque']:.4g} N*m"),
    ]
