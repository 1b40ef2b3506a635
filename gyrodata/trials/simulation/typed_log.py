"""The simulated log as a student would type it, and the true values of its runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError, insist_on_choice
from gyrodata.physics import Floats, motion
from gyrodata.quantities.units import DISPLAY, Uncertainty, from_si
from gyrodata.readings import check_value, kind_of_role, u_keys
from gyrodata.readings.lablog import header_of
from gyrodata.readings.roles import ROLES
from gyrodata.readings.writing import SIMULATED, uncertainty_text
from gyrodata.trials.simulation.noise import EXACT, NOISE_KEYS, TYPICAL, put_errors
from gyrodata.trials.simulation.truth import Design, Runs, Truth, happen, top_of

UNKNOWN_BIAS_U = 30.0
"""Uncertainty of the timing bias [s] that the log states if the truth has a bias and
the noise does not contain one."""


class Simulation(Struct, frozen=True):
    """A simulated log and its truth.

    Attributes
    ----------
    log : str
        The log as CSV text.
    truth : Truth
        The truth, with the values that were drawn at random.
    runs : Runs
        The true values, without errors.
    noise : mapping of str to Uncertainty
        The stated uncertainties by their ``u_…`` keys.
    """

    log: str
    truth: Truth
    runs: Runs
    noise: Mapping[str, Uncertainty]

    def __str__(self) -> str:
        return self.log

    def __repr__(self) -> str:
        return f"<Simulation of {len(self.runs.time)} runs>"


def simulate(
    truth: Truth | None = None,
    design: Design | None = None,
    noise: Mapping[str, Uncertainty] = TYPICAL,
    seed: int | None = 1,
) -> Simulation:
    """Simulate a log whose truth is known.

    By default, the lab has a balanced 4-inch steel ball, three weights and three spins.

    Parameters
    ----------
    truth : Truth, optional
        True properties of the gyroscope [SI units].
    design : Design, optional
        Weights, positions, spins, turns and pitches [SI units].
    noise : mapping of str to Uncertainty
        Standard uncertainties by their ``u_…`` keys; others are zero.
    seed : int or None
        Seed of the random numbers; the same seed gives the same log. None: the readings
        have no errors, and the log still states the uncertainties.

    Returns
    -------
    Simulation

    Raises
    ------
    InputError
        If a value is impossible, or if a rod does not complete its turns.
    ValueError
        If a key of `noise` is unknown.
    """
    for key in noise:
        insist_on_choice("a key of noise", key, NOISE_KEYS)
    random = np.random.default_rng(seed)
    errors = {} if seed is None else noise
    truth = _drawn(truth or Truth(), errors, random)
    runs = happen(truth, design or Design())
    true = true_readings(truth, runs)
    _insist_on_possible(true)
    read = put_errors(true, errors, random)
    # A mark that is sighted too far along makes the time too long; whole turns end at
    # the mark where they began.
    sighted = np.where(runs.turns % 1 != 0, read.pop("turns") / runs.turns, 1.0)
    read["time"] = read["time"] + runs.time * (sighted - 1) + truth.timing_bias
    _insist_on_possible(read)
    stated = _stated(truth, noise, runs, set(read))
    # Without errors, a reading is written with all its digits.
    cells = _cells_of_runs(runs, read, {} if seed is None else stated)
    summary = _summary(truth, "no errors" if seed is None else f"seed {seed}")
    return Simulation(_log(summary, truth, cells, stated), truth, runs, stated)


def _drawn(
    truth: Truth, noise: Mapping[str, Uncertainty], random: np.random.Generator
) -> Truth:
    """Draw the values that the truth leaves open and that the whole log shares."""
    values: dict[str, float] = {}
    for name, key in (("imbalance", "u_imbalance"), ("timing_bias", "u_time_bias")):
        width = noise.get(key, Uncertainty()).absolute
        # Zero, and not minus zero, without this noise.
        drawn = width * float(random.standard_normal()) + 0.0
        value = getattr(truth, name)
        values[name] = drawn if value is None else value
    return replace(truth, **values)


def true_readings(truth: Truth, runs: Runs) -> dict[str, Floats]:
    """Return the true value of everything that is read, by role."""
    is_released = truth.motion == "released"
    columns = {
        "g": np.full(len(runs.time), truth.g),
        "mass": np.where(runs.mass == 0, np.nan, runs.mass),
        "position": np.where(runs.mass == 0, np.nan, runs.position),
        "time": runs.time,
        "turns": runs.turns,
    }
    spin = runs.spin
    if is_released:
        # The tachometer follows the rod.
        spin = spin - motion.spin_excess(top_of(truth, runs), spin, runs.pitch)
    if runs.spin_end is None:
        columns["spin"] = np.abs(spin)
    else:
        columns["spin_start"] = np.abs(spin)
        columns["spin_end"] = np.abs(runs.spin_end)
    if runs.pitch.any():
        columns["pitch"] = runs.pitch
    if runs.pitch.any() or is_released:
        columns["transverse_inertia"] = runs.transverse_inertia
    return columns


def _insist_on_possible(readings: Mapping[str, Floats]) -> None:
    """Refuse readings that a log could not contain; NaN is a blank cell."""
    for role, values in readings.items():
        for run, value in enumerate(values.tolist(), start=1):
            fault, _ = check_value(role, value)
            if fault and not math.isnan(value):
                raise InputError.named(
                    "simulated_impossible", run=run, role=role, fault=fault
                )


def _stated(
    truth: Truth, noise: Mapping[str, Uncertainty], runs: Runs, roles: set[str]
) -> dict[str, Uncertainty]:
    """Return the uncertainties that the log states.

    They are the uncertainties that affect its readings, also if they are zero.
    """
    stated = {**EXACT, **noise}
    if truth.timing_bias and not stated["u_time_bias"].absolute:
        stated["u_time_bias"] = Uncertainty(UNKNOWN_BIAS_U)
    for role in {"pitch", "transverse_inertia"} - roles:
        del stated[f"u_{role}"]
    if not (runs.turns % 1).any():
        del stated["u_turns"]
    if truth.decay_time is None:
        del stated["u_decay_exponent"]
        # A constant spin is the same a moment later.
        stated["u_spin_delay"] = Uncertainty()
    else:
        del stated["u_spin_delay"]
    return stated


def _summary(truth: Truth, errors: str) -> str:
    """Write the truth for the first line of the log."""
    parts = [f"I_zz = {truth.inertia!r} kg*m^2"]
    if truth.transverse_inertia is not None:
        parts.append(f"I = {truth.transverse_inertia!r} kg*m^2")
    parts.append(f"residual torque {truth.imbalance:.6g} N*m")
    parts.append(f"timing bias {truth.timing_bias:.6g} s")
    parts.append(truth.motion)
    if truth.decay_time is not None:
        parts.append(f"spin decays with time constant {truth.decay_time!r} s")
    return ", ".join([*parts, errors])


def _log(
    summary: str,
    truth: Truth,
    cells: dict[str, list[str]],
    stated: Mapping[str, Uncertainty],
) -> str:
    """Write the log: ``#`` lines, a header and one line for each run."""
    g = cells.pop("g")[0]
    lines = [f"# {SIMULATED}: {summary}", f"# g: {g} {DISPLAY['acceleration']}"]
    for key, u in stated.items():
        lines.append(f"# {key}: {uncertainty_text(u, kind_of_role(key))}")
    lines.append(f"# motion: {truth.motion}")
    across = {*cells.get("transverse_inertia", [])}
    if len(across) == 1:
        del cells["transverse_inertia"]
        lines.append(f"# transverse_inertia: {across.pop()} {DISPLAY['inertia']}")
    roles = sorted(cells, key=ROLES.index)
    headers = [header_of(role, DISPLAY[kind_of_role(role)]) for role in roles]
    lines.append(",".join([*headers, "run"]))
    rows = zip(*[cells[role] for role in roles], strict=True)
    for number, row in enumerate(rows, start=1):
        lines.append(",".join([*row, str(number)]))
    return "\n".join(lines) + "\n"


def _cells_of_runs(
    runs: Runs, read: Mapping[str, Floats], stated: Mapping[str, Uncertainty]
) -> dict[str, list[str]]:
    """Write the readings as the cells of a log, by role."""
    columns: dict[str, list[str]] = {}
    for role, values in read.items():
        u = stated.get(u_keys(role)[-1], Uncertainty())
        columns[role] = _typed(values, u, role)
    for run in np.flatnonzero(runs.mass == 0):
        columns["mass"][run] = "0"
    columns["turns"] = [_as_fraction(turns) for turns in runs.turns.tolist()]
    if runs.spin.min() < 0:
        columns["spin_sense"] = _senses(runs.spin)
    if runs.sense.min() < 0 or not runs.mass.all():
        columns["precession_sense"] = _senses(runs.sense)
    return columns


def _as_fraction(turns: float) -> str:
    """Write 1/3 for a third, and other numbers as they are."""
    fraction = Fraction(turns).limit_denominator(100)
    return str(fraction if float(fraction) == turns else turns)


def _senses(values: Floats) -> list[str]:
    """Write the sense of rotation of each run."""
    return ["ccw" if value > 0 else "cw" for value in values]


def _typed(values: Floats, u: Uncertainty, role: str) -> list[str]:
    """Write readings with steps of a third of their uncertainty or less.

    A reading without an uncertainty is written with all its digits.
    """
    kind = kind_of_role(role)
    unit = DISPLAY[kind]
    there = values[~np.isnan(values)].tolist()
    spread = from_si(min(map(u.at, there), default=0.0), unit, kind)
    # Rounding then adds less than 0.5 % to the uncertainty, so that the stated one is
    # still true.
    digits = -math.floor(math.log10(spread / 3)) if spread > 0 else None
    return [_rounded(from_si(value, unit, kind), digits) for value in values.tolist()]


def _rounded(value: float, digits: int | None) -> str:
    """Write a number with some digits behind the point; None: with all of them."""
    if math.isnan(value):
        return ""
    if digits is None:
        return repr(value)
    return f"{round(value, digits):.{max(digits, 0)}f}"
