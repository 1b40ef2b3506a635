"""Known mistakes: the effect of a wrong unit, origin, count or column on I_zz; and the ranges of readings in this lab.

`mistakes.toml` contains one table for two uses: `gyro grade` looks for a mistake in the arithmetic of a reported value,
and `gyro analyze` looks for one in the log itself, if the log describes the ball.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.errors import Diagnostic
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, Floats
from gyrodata.readings import Column, Readings, kind_of_role, to_display
from gyrodata.units import from_si, parse_unit


class Mistake(Struct, frozen=True, forbid_unknown_fields=True):
    """One mistake, as in the table or as it can occur in a log of n runs; `mistakes.toml` explains the fields.

    For a log, `torque` and `product` are the factors by which the mistake multiplies M and φ̇ψ̇ of each run, a number or
    shape (n,). `log` is empty if only the arithmetic can contain the mistake, `words` is empty if only the log can.
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
    """Read the table of mistakes, by kind. Most logs do not need it, so it is read when it is used."""
    import tomllib
    from importlib.resources import files

    text = files("gyrodata").joinpath("mistakes.toml").read_text("utf-8")
    return {one.kind: one for one in convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])}


def list_mistakes(readings: Readings, measured: Measurements, inertia: float) -> Iterator[Mistake]:
    """List every mistake that is possible in this log, with its I_zz [kg*m^2]."""
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
            # A spin in Hz is a spin in revolutions per second.
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
    """Return the factors that depend on the log by their names in the table, without the impossible ones."""
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
        # Nobody spins the ball more slowly than 30 rpm.
        if np.all((spin < time) & (time > 30)):
            found["(time/spin)²"] = (time / spin) ** 2
    return found


def _unit(readings: Readings, role: str) -> str:
    return readings.columns[role].unit if role in readings.columns else ""


# --- what explains a log ---------------------------------------------------------------------------------------

CLOSE = 0.06
"""A mistake explains a log if I_zz without it differs from the expected value by less than this [1]."""

SCATTERS = 0.03
"""A correction is rejected if the runs scatter by this much more after it [1]."""

MOST = 3
"""Largest number of mistakes that are named."""

START_SPIN = (0.75, 0.96)
"""I_zz over its true value [1] if the spin was read at the start of each run instead of at half time."""


def explaining_mistakes(
    readings: Readings, measured: Measurements, inertia: float, expected: float
) -> tuple[tuple[Mistake, float], ...]:
    """Name the mistakes in a log that explain its I_zz, the most likely first, each with I_zz without it [kg*m^2].

    `inertia`, `expected`: I_zz from the log, and the value that it should be [kg*m^2].
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
            # Of two mistakes that fit equally well, the more common one comes first.
            found.append((away + 0.01 * mistake.rank, mistake, value))
    if START_SPIN[0] < inertia / expected < START_SPIN[1] and "spin" in readings.columns:
        words = f"the spin was read at the start, and was {100 * (1 - inertia / expected):.0f} % lower at half time"
        remedy = 'write spins read at half time, or the spin at start and end in columns "spin_start", "spin_end"'
        found.append((CLOSE, Mistake("start_spin", log=words, remedy=remedy), expected))
    found.sort(key=lambda item: item[0])
    return tuple((mistake, value) for _, mistake, value in found[:MOST])


def _scatter(each: Floats) -> float:
    """Relative spread of I_zz of the single runs, robust against one odd run."""
    logs = np.log(each)
    return float(np.median(np.abs(logs - np.median(logs))))


# --- the sizes of this lab --------------------------------------------------------------------------------------

INERTIA_RANGE = (1e-6, 1.0)
"""Range of I_zz of a body that is spun on a table [kg*m^2]."""


class Size(Struct, frozen=True):
    """Range of the readings of one role in this lab [SI unit]."""

    role: str
    possible: tuple[float, float]
    """A reading outside is impossible in this lab; all published logs are inside."""
    usual: tuple[float, float]
    """Nearly all logs are inside: gyro proposes the unit that brings a column into this range."""
    units: tuple[str, ...]


SIZES = (
    Size("mass", (1e-4, 5.0), (1e-3, 1.0), ("g", "kg", "mg")),
    Size("position", (2e-3, 1.0), (0.02, 0.6), ("cm", "mm", "m")),
    Size("spin", (10 * RPM, 60_000 * RPM), (60 * RPM, 10_000 * RPM), ("rpm", "Hz", "rad/s", "deg/s")),
    Size("time", (0.3, 1800.0), (1.0, 600.0), ("s", "min", "ms")),
)


def unit_within(readings: Readings, role: str, usual: tuple[float, float]) -> str:
    """Return another unit that brings all readings of a column into a usual range [SI unit]; "" if there is none."""
    values = [abs(value) for value in readings.columns[role].values if value]
    for unit, factor in other_units(readings.columns[role]):
        if usual[0] <= factor * min(values) and factor * max(values) <= usual[1]:
            return unit
    return ""


def meant_in(readings: Readings, size: Size, run: int) -> tuple[str, float] | None:
    """Return the unit in which a reading equals that of another run, and its value [SI unit]; None if there is none."""
    values = [abs(value or 0.0) for value in readings.columns[size.role].values]
    for unit, factor in other_units(readings.columns[size.role]):
        value = factor * values[run]
        if any(math.isclose(value, other, rel_tol=0.02) for other in values if other):
            return unit, value
    return None


def other_units(column: Column) -> Iterator[tuple[str, float]]:
    """List the other units that a column may have in this lab, each with the factor on its values."""
    own = _size_of(column.role, column.unit) if column.unit else 1.0
    for unit in next((size.units for size in SIZES if size.role == column.role), ()):
        factor = _size_of(column.role, unit) / own
        if not math.isclose(factor, 1.0):
            yield unit, factor


def exchanged(readings: Readings, measured: Measurements) -> bool:
    """Return whether spin and time are possible only if the two columns are exchanged."""
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


def size_findings(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Report readings that are impossible in this lab, and exchanged columns of spin and time."""
    if exchanged(readings, measured):
        spin, time = readings.columns["spin"], readings.columns["time"]
        return [readings.say("columns_exchanged", spin.place(0), spin=spin.header, time=time.header)]
    found = []
    for size in SIZES:
        column, kind, (least, most) = readings.columns.get(size.role), kind_of_role(size.role), size.possible
        values = column.values if column else ()
        run = next((run for run, value in enumerate(values) if value and not least <= abs(value) <= most), None)
        if column is None or run is None:
            continue
        unit = unit_within(readings, size.role, size.usual)
        own = column.unit or to_display(1.0, size.role)[1]
        meant, there = (unit, 0.0) if unit else meant_in(readings, size, run) or ("", 0.0)
        sizes = abs(column.values[run] or 0.0), *size.possible, there
        value, low, high, near = (f"{from_si(si, own, kind):.4g} {own}" for si in sizes)
        words = {"role": size.role, "value": value, "low": low, "high": high, "unit": meant, "there": near}
        name = "size_of_column" if unit else "size_of_cell" if meant else "size_unusual"
        found.append(readings.say(name, column.cell(run), **words))
    return found
