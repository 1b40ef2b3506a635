"""The simulated log as a student would type it, and the true values of its runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from numbers import Integral

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.errors import InputError, insist_on_choice, insist_on_type
from gyrodata.physics import Floats, motion
from gyrodata.quantities.notation import read_cell
from gyrodata.quantities.units import DISPLAY, Uncertainty, from_si
from gyrodata.readings import Readings, check_value, kind_of_role, read_log, u_keys
from gyrodata.readings.roles import ROLES
from gyrodata.readings.writing import SIMULATED, uncertainty_text
from gyrodata.trials.simulation.noise import EXACT, NOISE_KEYS, TYPICAL, put_errors
from gyrodata.trials.simulation.truth import Design, Runs, Truth, happen

UNKNOWN_BIAS_U = 30.0
"""Uncertainty of the timing bias [s] that the log states if the truth has a bias and
the noise does not contain one."""


class Simulation(Struct, frozen=True, dict=True):
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
    seed : int or None
        The seed of the random numbers.
    """

    log: str
    truth: Truth
    runs: Runs
    noise: Mapping[str, Uncertainty]
    seed: int | None

    def __str__(self) -> str:
        return self.log

    def __repr__(self) -> str:
        return (
            f"<Simulation of {len(self.runs.time)} runs: "
            f"I_zz = {self.truth.inertia:g} kg·m²>"
        )

    @cached_property
    def readings(self) -> Readings:
        """The readings of the log."""
        return read_log(self.log.encode(), name="<simulated>")


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
    TypeError, ValueError
        If an argument has the wrong type, or a key of `noise` is unknown.
    """
    insist_on_type("truth", truth, Truth | None, "a Truth")
    insist_on_type("design", design, Design | None, "a Design")
    insist_on_type("noise", noise, Mapping, "a mapping of u_… keys to Uncertainty")
    for key, u in noise.items():
        insist_on_choice("a key of noise", key, NOISE_KEYS)
        insist_on_type(f"noise[{key!r}]", u, Uncertainty, "an Uncertainty")
    insist_on_type("seed", seed, Integral | None, "a whole number")
    truth = truth or Truth()
    design = design or Design()
    random = np.random.default_rng(seed)
    truth = _drawn(truth, noise, random, seed)
    runs = happen(truth, design)
    true = _columns(truth, runs)
    read = put_errors(true, noise, random) if seed is not None else dict(true)
    # A mark that is sighted too far along makes the time too long; whole turns end at
    # the mark where they began.
    sighted = np.where(runs.turns % 1 != 0, read.pop("turns") / runs.turns, 1.0)
    read["time"] = read["time"] + runs.time * (sighted - 1) + truth.timing_bias
    stated = _stated(truth, noise, runs, set(read))
    return Simulation(_log(truth, runs, read, stated, seed), truth, runs, stated, seed)


def _drawn(
    truth: Truth,
    noise: Mapping[str, Uncertainty],
    random: np.random.Generator,
    seed: int | None,
) -> Truth:
    """Draw the values that the truth leaves open and that the whole log shares."""
    widths = [
        noise.get(key, Uncertainty()).absolute for key in ("u_imbalance", "u_time_bias")
    ]
    imbalance = bias = 0.0
    if seed is not None:
        imbalance, bias = (random.standard_normal(2) * widths).tolist()
    return replace(
        truth,
        imbalance=imbalance if truth.imbalance is None else truth.imbalance,
        timing_bias=bias if truth.timing_bias is None else truth.timing_bias,
    )


def _columns(truth: Truth, runs: Runs) -> dict[str, Floats]:
    """Return the true value of everything that is read, by role."""
    columns = {
        "g": np.full(len(runs.time), truth.g),
        "mass": np.where(runs.mass == 0, np.nan, runs.mass),
        "position": np.where(runs.mass == 0, np.nan, runs.position),
        "time": runs.time,
        "turns": runs.turns,
    }
    if runs.spin_end is None:
        columns["spin"] = np.abs(runs.spin)
        if truth.motion == "released":
            # The tachometer follows the rod.
            top = motion.Top(truth.inertia, runs.transverse_inertia, runs.torque)
            columns["spin"] = np.abs(
                runs.spin - motion.spin_excess(top, runs.spin, runs.pitch)
            )
    else:
        columns |= {"spin_start": np.abs(runs.spin), "spin_end": np.abs(runs.spin_end)}
    if runs.pitch.any():
        columns["pitch"] = runs.pitch
    if runs.pitch.any() or truth.motion == "released":
        columns["transverse_inertia"] = runs.transverse_inertia
    return columns


def _stated(
    truth: Truth, noise: Mapping[str, Uncertainty], runs: Runs, roles: set[str]
) -> dict[str, Uncertainty]:
    """Return the uncertainties that the log states.

    They are the uncertainties that affect its readings, also if they are zero.
    """
    absent = {
        f"u_{role}" for role in ("pitch", "transverse_inertia") if role not in roles
    }
    if not (runs.turns % 1).any():
        absent.add("u_turns")
    absent.add("u_decay_exponent" if truth.decay_time is None else "u_spin_delay")
    stated = {**EXACT, **noise}
    if truth.timing_bias and not stated["u_time_bias"].absolute:
        stated["u_time_bias"] = Uncertainty(UNKNOWN_BIAS_U)
    if truth.decay_time is None:
        # A constant spin is the same a moment later.
        stated["u_spin_delay"] = Uncertainty()
    return {key: u for key, u in stated.items() if key not in absent}


def _log(
    truth: Truth,
    runs: Runs,
    read: dict[str, Floats],
    stated: dict[str, Uncertainty],
    seed: int | None,
) -> str:
    """Write the log: ``#`` lines, a header and one line for each run."""
    columns = _cells_of_runs(runs, read, {} if seed is None else stated)
    head = {
        SIMULATED: _summary(truth, seed),
        "g": f"{columns.pop('g')[0]} {DISPLAY['acceleration']}",
    }
    for key, u in stated.items():
        head[key] = uncertainty_text(u, kind_of_role(key))
    head["motion"] = truth.motion
    across = columns.get("transverse_inertia", [])
    if len(set(across)) == 1:
        head["transverse_inertia"] = f"{across[0]} {DISPLAY['inertia']}"
        del columns["transverse_inertia"]
    table: dict[str, list[str]] = {}
    for role in sorted(columns, key=ROLES.index):
        unit = DISPLAY[kind_of_role(role)]
        table[f"{role} [{unit}]" if unit else role] = columns[role]
    table["run"] = [str(i + 1) for i in range(len(runs.time))]
    filled = {header: cells for header, cells in table.items() if any(cells)}
    lines = [f"# {key}: {value}" for key, value in head.items()]
    lines.append(",".join(filled))
    lines += map(",".join, zip(*filled.values(), strict=True))
    return "\n".join(lines) + "\n"


def _cells_of_runs(
    runs: Runs, read: dict[str, Floats], stated: dict[str, Uncertainty]
) -> dict[str, list[str]]:
    """Write the readings as the cells of a log, by role.

    A reading without a stated uncertainty is written with all its digits.
    """
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

    Raises
    ------
    InputError
        If a reading could not be typed into a log.
    """
    kind = kind_of_role(role)
    unit = DISPLAY[kind]
    sizes = [u.at(float(value)) for value in values if not math.isnan(value)]
    spread = from_si(min(sizes, default=0.0), unit, kind)
    # Rounding then adds less than 0.5 % to the uncertainty, so that the stated one is
    # still true.
    digits = -math.floor(math.log10(spread / 3)) if spread > 0 else None
    texts = []
    for run, value in enumerate(values, start=1):
        text = ""
        if not math.isnan(value):
            text = _rounded(from_si(float(value), unit, kind), digits)
            _insist_on_possible(text, role, run)
        texts.append(text)
    return texts


def _rounded(value: float, digits: int | None) -> str:
    """Write a number with some digits behind the point; None: with all of them."""
    if digits is None:
        return repr(value)
    return f"{round(value, digits):.{max(digits, 0)}f}"


def _insist_on_possible(text: str, role: str, run: int) -> None:
    """Raise InputError if a simulated reading is impossible."""
    kind = kind_of_role(role)
    unit = DISPLAY[kind]
    fault, _ = check_value(role, read_cell(text, kind, unit).value)
    if not fault:
        return
    raise InputError.named(
        "simulated_reading_impossible",
        run=run,
        role=role,
        value=float(text),
        unit=unit,
        fault=fault,
    )


def _summary(truth: Truth, seed: int | None) -> str:
    """Write the truth for the first line of the log."""
    parts = [f"I_zz = {truth.inertia!r} kg*m^2"]
    if truth.transverse_inertia is not None:
        parts.append(f"I = {truth.transverse_inertia!r} kg*m^2")
    parts += [
        f"residual torque {truth.imbalance:.6g} N*m",
        f"timing bias {truth.timing_bias:.6g} s",
        truth.motion,
    ]
    if truth.decay_time is not None:
        parts.append(f"spin decays with time constant {truth.decay_time!r} s")
    return ", ".join([*parts, "no errors" if seed is None else f"seed {seed}"])
