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
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.measurements import Measurements, spin_columns
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
        mistake.kind: mistake
        for mistake in convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])
    }


def list_mistakes(
    readings: Readings, measured: Measurements, inertia: float
) -> Iterator[Mistake]:
    """List every mistake that is possible in this log, with its I_zz [kg*m^2]."""
    units = _units(readings, measured)
    factors = _factors_of_log(readings, measured, inertia)
    there = {"", *readings.columns, *readings.constants}
    for known in known_mistakes().values():
        if known.needs not in there:
            continue
        unit = units.get(known.column, "")
        # A number stands for itself.
        torque = factors.get(known.torque, known.torque)
        product = factors.get(known.product, known.product)
        rank = known.rank
        if known.common_in:
            rank = int(unit not in known.common_in)
        mistake = replace(known, torque=torque, product=product, rank=rank)
        if known.read:
            mistake = _of_units(mistake, unit)
        factor = mistake.torque / mistake.product
        has_effect = np.any(np.isfinite(factor) & (factor != 1))
        if has_effect and (mistake.words or mistake.log):
            yield _in_words(mistake, readings, measured)


def _units(readings: Readings, measured: Measurements) -> dict[str, str]:
    """Return the units of the columns of a log, and the number of turns of all runs."""
    units = {role: _unit(readings, role) for role in ("time", "mass", "position")}
    units["spin"] = spin_columns(readings)[0].unit or "rpm"
    if measured.timed:
        for words, count in COUNTS.items():
            if np.allclose(measured.turns, count):
                units["turns"] = words
    return units


def _of_units(mistake: Mistake, unit: str) -> Mistake:
    """Return a mistake about a unit, with its factors, for a column in `unit`."""
    column = mistake.column
    factor = _size_of(column, mistake.read) / _size_of(column, mistake.meant)
    if unit == "rps":
        # A spin in Hz is a spin in revolutions per second.
        unit = "Hz"
    log = mistake.log if mistake.read == unit else ""
    header = f"{column} [{mistake.meant}]"
    remedy = mistake.remedy or f'write the header as "{header}"'
    mistake = replace(mistake, remedy=remedy, log=log)
    if column in ("mass", "position"):
        return replace(mistake, torque=factor)
    return replace(mistake, product=1 / factor if column == "time" else factor)


def _in_words(mistake: Mistake, readings: Readings, measured: Measurements) -> Mistake:
    """Return a mistake with the values of a log in its words."""
    diameter = 100 * readings.constants.get("ball_diameter", math.nan)
    lengths = {"radius": diameter / 2, "twice_diameter": 2 * diameter}
    texts = {
        name: getattr(mistake, name).format(g=measured.g, **lengths)
        for name in ("words", "check", "log", "remedy")
    }
    return replace(mistake, **texts)


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

    Impossible factors are NaN.
    """
    turns = measured.turns
    least = turns.min() if measured.timed else 0.0
    is_in_kg = _unit(readings, "mass") == "kg"
    power = math.floor(math.log10(abs(inertia)))
    factors: dict[str, float | Floats] = {
        "1/g": 1 / measured.g,
        "g, of weights in kg": measured.g if is_in_kg else math.nan,
        "1/turns": 1 / turns,
        "1/turns²": turns**-2,
        "turns²": turns**2 if least >= 2 else math.nan,
        "360, of many turns": 360.0 if least > 20 else math.nan,
        "1/power of ten": 10.0**-power,
        "1/power of ten²": 100.0**-power,
        "none: 1/I_zz is no multiple of I_zz": math.nan,
    }
    with np.errstate(all="ignore"):
        factors |= _factors_of_arms(readings, measured)
        return factors | _spin_by_time(readings, measured)


def _factors_of_arms(
    readings: Readings, measured: Measurements
) -> dict[str, float | Floats]:
    """Return the factors of positions that count from another point."""
    arm = np.abs(measured.position)
    radius = readings.constants.get("ball_diameter", math.nan) / 2
    length = readings.constants.get("rod_length", math.nan)
    outside = np.where(arm > radius, arm - radius, math.nan)
    from_tip = np.where(arm < length + radius, length + radius - arm, math.nan)
    return {
        "(arm - radius)/arm": np.where(measured.torque == 0, 1.0, outside / arm),
        "arm/(arm + radius)": arm / (arm + radius),
        "arm/(arm - radius)": arm / outside,
        "arm/(length + radius - arm)": arm / from_tip,
    }


def _spin_by_time(
    readings: Readings, measured: Measurements
) -> dict[str, float | Floats]:
    """Return the factors of exchanged columns of spin [rpm] and time [s]."""
    ratio = measured.spin / RPM / measured.time
    if _unit(readings, "spin") != "rpm" or _unit(readings, "time") != "s":
        ratio = np.full_like(ratio, math.nan)
    # Nobody spins the ball more slowly than 30 rpm.
    is_possible = np.all((ratio < 1) & (measured.time > 30))
    return {
        "(spin/time)²": ratio**2,
        "(time/spin)²": ratio**-2 if is_possible else math.nan,
    }


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

START_REMEDY = (
    "write spins read at half time, or the spin at start and end in columns "
    '"spin_start", "spin_end"'
)


def explaining_mistakes(
    readings: Readings, measured: Measurements, inertia: float, expected: float
) -> tuple[tuple[Mistake, float], ...]:
    """Name the mistakes in a log that explain its I_zz, the most likely first.

    Each mistake is listed with the I_zz without it [kg*m^2].

    `inertia`, `expected`: I_zz from the log, and the value that it should be [kg*m^2].
    """
    ranked = []
    for mistake in list_mistakes(readings, measured, inertia):
        value = _inertia_without(mistake, measured, inertia) if mistake.log else None
        away = abs(math.log((value or math.inf) / expected))
        if value and away < CLOSE:
            # Of two mistakes that fit equally well, the more common one comes first.
            ranked.append((away + 0.01 * mistake.rank, mistake, value))
    low, high = START_SPIN
    if low < inertia / expected < high and "spin" in readings.columns:
        percent = 100 * (1 - inertia / expected)
        log = (
            "the spin was read at the start, "
            f"and was {percent:.0f} % lower at half time"
        )
        ranked.append(
            (CLOSE, Mistake("start_spin", log=log, remedy=START_REMEDY), expected)
        )
    ranked.sort(key=itemgetter(0))
    return tuple([(mistake, value) for _, mistake, value in ranked[:MOST]])


def _inertia_without(
    mistake: Mistake, measured: Measurements, inertia: float
) -> float | None:
    """Return I_zz without a mistake [kg*m^2]; None if the runs then scatter more."""
    loaded = measured.torque != 0
    factor = np.broadcast_to(mistake.torque / mistake.product, loaded.shape)[loaded]
    each = measured.single_inertia[loaded]
    mended = each / factor
    if not np.isfinite(mended).all():
        return None
    if _spread(mended) > _spread(each) + SCATTERS:
        return None
    return inertia * float(np.median(mended) / np.median(each))


SCATTERS = 0.03
"""A correction is rejected if the runs scatter by this much more after it [1]."""


def _spread(each: Floats) -> float:
    """Return the relative spread of I_zz of the runs [1], robust against outliers."""
    logs = np.log(each)
    return float(np.median(np.abs(logs - np.median(logs))))
