"""Known mistakes: what a wrong unit, origin, count or column does to I_zz; and the sizes of this lab.

`mistakes.toml` contains one table for both who make mistakes: `gyro grade` looks for one in the arithmetic behind a
reported value, and `gyro analyze` for one in the log itself, if the ball says what I_zz should be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, Floats
from gyrodata.readings import Column, Readings, kind_of_role
from gyrodata.units import parse_unit


class Mistake(Struct, frozen=True, forbid_unknown_fields=True):
    """One mistake, as in the table or as a log of n runs can have it; `mistakes.toml` explains the fields.

    For a log, `torque` and `product` are what the mistake multiplies M and φ̇ψ̇ of each run by, a number or shape (n,).
    `log` is empty if only the arithmetic can have the mistake, `words` is empty if only the log can.
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
"""Turns that are taken for each other, as the table writes them."""


@cache
def known_mistakes() -> dict[str, Mistake]:
    """Read the table; by kind. Most logs never need it, nor what reads it."""
    import tomllib
    from importlib.resources import files

    text = files("gyrodata").joinpath("mistakes.toml").read_text("utf-8")
    return {one.kind: one for one in convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])}


def list_mistakes(readings: Readings, measured: Measurements, inertia: float) -> Iterator[Mistake]:
    """Give every single mistake that this log, and its I_zz [kg*m^2], can have."""
    units = {role: _unit(readings, role) for role in ("time", "mass", "position")}
    units["spin"] = next((c.unit for role, c in readings.columns.items() if role.startswith("spin") and c.unit), "rpm")
    if measured.timed:
        units["turns"] = next((words for words, count in COUNTS.items() if np.allclose(measured.turns, count)), "")
    factors = _factors_of_log(readings, measured, inertia)
    diameter, small = 100 * readings.constants.get("ball_diameter", math.nan), abs(inertia) < 1
    shown: dict[str, Any] = {"g": measured.g, "radius": diameter / 2, "twice_diameter": 2 * diameter}
    shown |= {"size": "below", "sign": "negative"} if small else {"size": "above", "sign": "positive"}
    for one in known_mistakes().values():
        unit = units.get(one.column, "")
        torque, product = (factors.get(by) if isinstance(by, str) else by for by in (one.torque, one.product))
        log, remedy = one.log, one.remedy
        if one.read:
            # A rotation in Hz is one in revolutions a second.
            log = log if one.read in (unit, "Hz" if unit == "rps" else unit) else ""
            remedy = remedy or f'write the header as "{one.column} [{one.meant}]"'
        missing = one.needs and not (one.needs in readings.columns or one.needs in readings.constants)
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
            one, words=words, check=check, log=log, remedy=remedy, torque=torque, product=product,
            rank=int(unit not in one.common_in) if one.common_in else one.rank,
            forgets=one.forgets if unit in one.forgets_in or not one.forgets_in else "",
        )  # fmt: skip


def _size_of(column: str, unit: str) -> float:
    return COUNTS[unit] if column == "turns" else parse_unit(unit, kind_of_role(column)).factor


def _factors_of_log(readings: Readings, measured: Measurements, inertia: float) -> dict[str, float | Floats]:
    """Give the factors that depend on the log by their names in the table, without those that it cannot have."""
    turns, arm, nan = measured.turns, np.abs(measured.position), np.nan
    diameter, length = readings.constants.get("ball_diameter"), readings.constants.get("rod_length")
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
            found["(arm - radius)/arm"] = np.where(measured.torque == 0, 1.0, outside / arm)
            found["arm/(arm + radius)"] = arm / (arm + radius)
            found["arm/(arm - radius)"] = arm / outside
            found["arm/(arm - radius), of an arm beyond the ball"] = np.where(arm > diameter, arm / outside, nan)
        if length is not None:
            from_tip = length + (diameter or 0.0) / 2 - arm
            found["arm/(length + radius - arm)"] = np.where(from_tip > 0, arm / from_tip, nan)
    power = math.floor(math.log10(abs(inertia)))
    if power:
        found |= {"1/power of ten": 10.0**-power, "1/power of ten²": 100.0**-power}
    if _unit(readings, "spin") == "rpm" and _unit(readings, "time") == "s":
        spin, time = measured.spin / RPM, measured.time
        found["(spin/time)²"] = (spin / time) ** 2
        # No rod is spun more slowly than 30 rpm.
        if np.all((spin < time) & (time > 30)):
            found["(time/spin)²"] = (time / spin) ** 2
    return found


def _unit(readings: Readings, role: str) -> str:
    return readings.columns[role].unit if role in readings.columns else ""


# --- what explains a log ---------------------------------------------------------------------------------------

CLOSE = 0.06
"""A mistake explains a log if without it I_zz is nearer to what it should be than this share."""

SCATTERS = 0.03
"""A mistake is none if it leaves the runs scattered by so much more than they were [1]."""

MOST = 3
"""So many mistakes are named."""

START_SPIN = (0.75, 0.96)
"""I_zz over its true value [1] if the spin was read at the start of each run instead of at half time."""


def explaining_mistakes(
    readings: Readings, measured: Measurements, inertia: float, expected: float
) -> tuple[tuple[Mistake, float], ...]:
    """Name the mistakes in a log that explain an I_zz, the likeliest first, with I_zz without each [kg*m^2].

    `inertia`, `expected`: I_zz as the log has it, and as it should be [kg*m^2].
    """
    loaded = measured.torque != 0
    each = np.abs(measured.torque / measured.product)[loaded]
    before, found = _scatter(each), []
    for mistake in list_mistakes(readings, measured, inertia):
        mended = each / np.broadcast_to(mistake.torque / mistake.product, measured.torque.shape)[loaded]
        if not mistake.log or not np.isfinite(mended).all() or _scatter(mended) > before + SCATTERS:
            continue
        value = inertia * float(np.median(mended) / np.median(each))
        away = abs(math.log(value / expected))
        if away < CLOSE:
            # Of two that are as near, the commoner one.
            found.append((away + 0.01 * mistake.rank, mistake, value))
    if START_SPIN[0] < inertia / expected < START_SPIN[1] and "spin" in readings.columns:
        words = f"the spin was read at the start, and was {100 * (1 - inertia / expected):.0f} % lower at half time"
        remedy = 'write spins read at half time, or the spin at start and end in columns "spin_start", "spin_end"'
        found.append((CLOSE, Mistake("start_spin", log=words, remedy=remedy), expected))
    found.sort(key=lambda item: item[0])
    return tuple((mistake, value) for _, mistake, value in found[:MOST])


def _scatter(each: Floats) -> float:
    """Spread of I_zz of single runs as a share, robust against one that is odd."""
    logs = np.log(each)
    return float(np.median(np.abs(logs - np.median(logs))))


# --- the sizes of this lab --------------------------------------------------------------------------------------

INERTIA_RANGE = (1e-6, 1.0)
"""I_zz of what is spun on a table [kg*m^2]."""


class Size(Struct, frozen=True):
    """How large a reading of this lab is [SI unit]."""

    role: str
    possible: tuple[float, float]
    """What lies outside is not of this lab: every published log lies within."""
    usual: tuple[float, float]
    """Nearly all logs lie here: the unit that brings a column here is proposed."""
    units: tuple[str, ...]


SIZES = (
    Size("mass", (1e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg")),
    Size("position", (2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m")),
    Size("spin", (10 * RPM, 60_000 * RPM), (60 * RPM, 10_000 * RPM), ("rpm", "Hz", "rad/s", "deg/s")),
    Size("time", (0.3, 1800.0), (1.0, 600.0), ("s", "min", "ms")),
)


def far_off(readings: Readings, size: Size) -> tuple[int, str] | None:
    """Find the first run whose reading is not of this lab, and the unit that it would be in; None if all are."""
    values, (low, high) = readings.columns[size.role].values if size.role in readings.columns else (), size.possible
    run = next((run for run, value in enumerate(values) if value and not low <= abs(value) <= high), None)
    return None if run is None else (run, unit_within(readings, size.role, size.usual))


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Find the other unit that brings all readings of a column into a usual range [SI unit]; "" if none does."""
    values = [abs(value) for value in readings.columns[role].values if value]
    for unit, factor in other_units(readings.columns[role]):
        if usual[0] <= factor * min(values) and factor * max(values) <= usual[1]:
            return unit
    return ""


def meant_in(readings: Readings, size: Size, run: int) -> tuple[str, float] | None:
    """Find the unit in which a reading is what other runs read, and that [SI unit]; None if there is none."""
    values = [abs(value or 0.0) for value in readings.columns[size.role].values]
    for unit, factor in other_units(readings.columns[size.role]):
        value = factor * values[run]
        if any(math.isclose(value, other, rel_tol=0.02) for other in values if other):
            return unit, value
    return None


def other_units(column: Column) -> Iterator[tuple[str, float]]:
    """Give the other units of this lab that a column may be in, and what each multiplies its values by."""
    own = _size_of(column.role, column.unit) if column.unit else 1.0
    for unit in next((size.units for size in SIZES if size.role == column.role), ()):
        factor = _size_of(column.role, unit) / own
        if not math.isclose(factor, 1.0):
            yield unit, factor


def exchanged(readings: Readings, measured: Measurements) -> bool:
    """Tell whether the numbers of spin and time make sense only the other way round."""
    if _unit(readings, "spin") != "rpm" or _unit(readings, "time") != "s" or not measured.torque.any():
        return False
    spins, times = (readings.columns[role] for role in ("spin", "time"))
    if min(spins.spots) < 0 or min(times.spots) < 0:
        return False
    sizes = {size.role: size for size in SIZES}
    for role, factor, values in (("spin", RPM, times.values), ("time", 1 / RPM, spins.values)):
        low, high = sizes[role].usual
        if not all(value and low <= factor * abs(value) <= high for value in values):
            return False
    loaded = measured.torque != 0
    each = np.abs(measured.torque / measured.product)[loaded]
    other = each * (measured.spin / RPM / measured.time)[loaded] ** 2
    low, high = sizes["spin"].possible
    odd = any(not low <= abs(value or 0.0) <= high for value in spins.values)
    return _scatter(other) < (_scatter(each) + SCATTERS if odd else _scatter(each) / 4)
