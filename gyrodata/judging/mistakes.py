"""Known mistakes: the effect of a wrong unit, origin, count or column on I_zz.

`mistakes.toml` contains one table for two uses: `gyro grade` looks for a mistake in the
arithmetic of a reported value, and `gyro analyze` looks for one in the log itself, if
the log describes the ball.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.measurements import Measurements, checks
from gyrodata.physics import RPM, Floats
from gyrodata.quantities.units import parse_unit
from gyrodata.readings import Readings, kind_of_role


class Mistake(Struct, frozen=True, forbid_unknown_fields=True):
    """One mistake, as in the table or as it can occur in a log of n runs.

    `mistakes.toml` explains the fields.

    For a log, `torque` and `product` are the factors by which the mistake multiplies M
    and φ̇ψ̇ of each run, a number or shape (n,). `log` is empty if only the arithmetic
    can contain the mistake, `words` is empty if only the log can.
    """

    kind: str
    words: str = ""
    check: str = ""
    log: str = ""
    remedy: str = ""
    torque: Any = 1.0
    product: Any = 1.0
    column: str = ""
    meant: str = ""
    read: str = ""
    rank: int = 0
    common_in: tuple[str, ...] = ()
    forgets: str = ""
    forgets_in: tuple[str, ...] = ()
    needs: str = ""


COUNTS = {"1": 1.0, "1/3": 1 / 3, "2/3": 2 / 3}
"""Numbers of turns that students confuse, as the table writes them."""


@cache
def known_mistakes() -> dict[str, Mistake]:
    """Read the table of mistakes, by kind.

    Most logs do not need it, so it is read when it is used.
    """
    text = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
    return {
        one.kind: one
        for one in convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])
    }


def list_mistakes(
    readings: Readings, measured: Measurements, inertia: float
) -> Iterator[Mistake]:
    """List every mistake that is possible in this log, with its I_zz [kg*m^2]."""
    units = {role: _unit(readings, role) for role in ("time", "mass", "position")}
    units["spin"] = next(
        (
            c.unit
            for role, c in readings.columns.items()
            if role.startswith("spin") and c.unit
        ),
        "rpm",
    )
    if measured.timed:
        units["turns"] = next(
            (
                words
                for words, count in COUNTS.items()
                if np.allclose(measured.turns, count)
            ),
            "",
        )
    factors = _factors_of_log(readings, measured, inertia)
    diameter = 100 * readings.constants.get("ball_diameter", math.nan)
    small = abs(inertia) < 1
    shown: dict[str, Any] = {
        "g": measured.g,
        "radius": diameter / 2,
        "twice_diameter": 2 * diameter,
    }
    shown |= (
        {"size": "below", "sign": "negative"}
        if small
        else {"size": "above", "sign": "positive"}
    )
    for one in known_mistakes().values():
        unit = units.get(one.column, "")
        torque, product = (
            factors.get(by) if isinstance(by, str) else by
            for by in (one.torque, one.product)
        )
        log = one.log
        remedy = one.remedy
        if one.read:
            # A spin in Hz is a spin in revolutions per second.
            names_of_unit = {unit, "Hz"} if unit == "rps" else {unit}
            if one.read not in names_of_unit:
                log = ""
            remedy = remedy or f'write the header as "{one.column} [{one.meant}]"'
        missing = one.needs and not (
            one.needs in readings.columns or one.needs in readings.constants
        )
        if missing or torque is None or product is None or not (one.words or log):
            continue
        if one.read:
            factor = _size_of(one.column, one.read) / _size_of(one.column, one.meant)
            if one.column in ("mass", "position"):
                torque = factor
            else:
                product = 1 / factor if one.column == "time" else factor
        texts = (one.words, one.check, log, remedy)
        words, check, log, remedy = (text.format(unit=unit, **shown) for text in texts)
        yield replace(
            one,
            words=words,
            check=check,
            log=log,
            remedy=remedy,
            torque=torque,
            product=product,
            rank=int(unit not in one.common_in) if one.common_in else one.rank,
            forgets=one.forgets if unit in one.forgets_in or not one.forgets_in else "",
        )


def _size_of(column: str, unit: str) -> float:
    return (
        COUNTS[unit]
        if column == "turns"
        else parse_unit(unit, kind_of_role(column)).factor
    )


def _factors_of_log(
    readings: Readings, measured: Measurements, inertia: float
) -> dict[str, float | Floats]:
    """Return the factors that depend on the log, by their names in the table.

    Impossible factors are left out.
    """
    turns = measured.turns
    arm = np.abs(measured.position)
    nan = np.nan
    diameter = readings.constants.get("ball_diameter")
    length = readings.constants.get("rod_length")
    found: dict[str, float | Floats] = {"1/g": 1 / measured.g}
    if _unit(readings, "mass") == "kg":
        found["g, of weights in kg"] = measured.g
    if np.any(turns != 1):
        found |= {"1/turns": 1 / turns, "1/turns²": turns**-2}
    if measured.timed and np.all(turns >= 2):
        found["turns²"] = turns**2
    if measured.timed and np.all(turns > 20):
        found["360, of many turns"] = 360.0
    with np.errstate(all="ignore"):
        if diameter is not None:
            radius = diameter / 2
            outside = np.where(arm > radius, arm - radius, nan)
            found["(arm - radius)/arm"] = np.where(
                measured.torque == 0, 1.0, outside / arm
            )
            found["arm/(arm + radius)"] = arm / (arm + radius)
            found["arm/(arm - radius)"] = arm / outside
            found["arm/(arm - radius), of an arm beyond the ball"] = np.where(
                arm > diameter, arm / outside, nan
            )
        if length is not None:
            from_tip = length + (diameter or 0.0) / 2 - arm
            found["arm/(length + radius - arm)"] = np.where(
                from_tip > 0, arm / from_tip, nan
            )
    power = math.floor(math.log10(abs(inertia)))
    if power:
        found |= {"1/power of ten": 10.0**-power, "1/power of ten²": 100.0**-power}
    if _unit(readings, "spin") == "rpm" and _unit(readings, "time") == "s":
        spin = measured.spin / RPM
        time = measured.time
        found["(spin/time)²"] = (spin / time) ** 2
        # Nobody spins the ball more slowly than 30 rpm.
        if np.all((spin < time) & (time > 30)):
            found["(time/spin)²"] = (time / spin) ** 2
    return found


def _unit(readings: Readings, role: str) -> str:
    return readings.columns[role].unit if role in readings.columns else ""


# --- what explains a log ---

CLOSE = 0.06
"""A mistake explains a log if I_zz without it differs from the expected value by less
than this [1]."""

MOST = 3
"""Largest number of mistakes that are named."""

START_SPIN = (0.75, 0.96)
"""I_zz over its true value [1] if the spin was read at the start of each run instead of
at half time."""


def explaining_mistakes(
    readings: Readings, measured: Measurements, inertia: float, expected: float
) -> tuple[tuple[Mistake, float], ...]:
    """Name the mistakes in a log that explain its I_zz, the most likely first.

    Each mistake is listed with the I_zz without it [kg*m^2].

    `inertia`, `expected`: I_zz from the log, and the value that it should be [kg*m^2].
    """
    loaded = measured.torque != 0
    each = np.abs(measured.torque / measured.product)[loaded]
    before = checks.spread(each)
    found = []
    for mistake in list_mistakes(readings, measured, inertia):
        mended = (
            each
            / np.broadcast_to(mistake.torque / mistake.product, measured.torque.shape)[
                loaded
            ]
        )
        if (
            not mistake.log
            or not np.isfinite(mended).all()
            or checks.spread(mended) > before + checks.SCATTERS
        ):
            continue
        value = inertia * float(np.median(mended) / np.median(each))
        away = abs(math.log(value / expected))
        if away < CLOSE:
            # Of two mistakes that fit equally well, the more common one comes first.
            found.append((away + 0.01 * mistake.rank, mistake, value))
    if (
        START_SPIN[0] < inertia / expected < START_SPIN[1]
        and "spin" in readings.columns
    ):
        words = (
            f"the spin was read at the start, and was "
            f"{100 * (1 - inertia / expected):.0f} % lower at half time"
        )
        remedy = (
            "write spins read at half time, or the spin at start and end in columns "
            '"spin_start", "spin_end"'
        )
        found.append((CLOSE, Mistake("start_spin", log=words, remedy=remedy), expected))
    found.sort(key=lambda item: item[0])
    return tuple((mistake, value) for _, mistake, value in found[:MOST])
