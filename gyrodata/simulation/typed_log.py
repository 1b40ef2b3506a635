"""The log that a student would have typed, and the truth behind it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from numbers import Integral
from typing import Any, cast

import numpy as np
from msgspec import Struct, to_builtins
from msgspec.structs import replace
from numpy.typing import NDArray

from gyrodata import __version__
from gyrodata.diagnostics import SIMULATED_VALUE_IMPOSSIBLE
from gyrodata.errors import InputError, insist_on_choice, insist_on_type
from gyrodata.physics import VISCOUS, Floats
from gyrodata.readings import Column, Reading, Readings, check_value, kind_of_role, read_cell, u_keys, write_log
from gyrodata.simulation.noise import EXACT, NOISE_KEYS, TYPICAL, put_errors
from gyrodata.simulation.truth import EXPONENTS, Design, Runs, Truth, happen
from gyrodata.units import DISPLAY, Uncertainty, from_si

SCHEMA = "gyro.truth/1"

UNKNOWN_BIAS_U = 30.0
"""What a log says of the timing bias [s] where the noise has none and the truth has one: that nobody knows it,
but that it is no hour: b is told to the last digits only in a unit of its own size."""


class Simulation(Struct, frozen=True):
    """A log, and the truth behind it."""

    readings: Readings
    """What is read, n runs; `measure` and the fit take it as it is."""
    truth: Truth
    """With everything that was drawn filled in."""
    runs: Runs
    """What happened, without any error."""
    noise: Mapping[str, Uncertainty]
    """``u_…`` by key, as the log states them."""
    seed: int | None

    @property
    def log(self) -> str:
        """The log as CSV text."""
        return write_log(self.readings)

    def to_dict(self) -> dict[str, Any]:
        """Give the truth for programs, SI: schema "gyro.truth/1"."""
        runs = self.runs
        columns: dict[str, Floats | None] = {
            "mass": runs.mass,
            "position": np.where(runs.mass == 0, np.nan, runs.position),
            "torque": runs.torque,
            "transverse_inertia": runs.across,
            "pitch": runs.pitch,
            "spin": runs.spin,
            "spin_half": runs.spin_half,
            "spin_end": runs.spin_end,
            "turns": runs.turns,
            "time": runs.time,
            "precession_rate": runs.sense * 2 * np.pi * runs.turns / runs.time,
        }
        return {
            "schema": SCHEMA,
            "tool": {"name": "gyrodata", "version": __version__},
            "seed": self.seed,
            "truth": to_builtins(self.truth),
            "noise": {key: to_builtins(u) for key, u in self.noise.items()},
            "runs": [
                {"run": label} | {name: _or_none(values, i) for name, values in columns.items()}
                for i, label in enumerate(self.readings.runs)
            ],
        }


def _or_none(values: Floats | None, i: int) -> float | None:
    return None if values is None or math.isnan(values[i]) else float(values[i])


def simulate(
    truth: Truth | None = None,
    design: Design | None = None,
    noise: Mapping[str, Uncertainty] = TYPICAL,
    seed: int | None = 1,
) -> Simulation:
    """Make a log from a known truth; by default a well balanced 4-inch steel ball, three weights and three spins.

    Parameters
    ----------
    truth : Truth, optional
        The ball and its motion, SI.
    design : Design, optional
        What is measured: weights, positions, spins, turns, SI.
    noise : mapping of str to Uncertainty
        Standard uncertainties by their ``u_…`` keys.
    seed : int or None
        Of the random numbers.

    Returns
    -------
    Simulation

    Raises
    ------
    InputError
        If there is no such lab.
    TypeError
        If an argument is nothing that it can be.

    Notes
    -----
    The same seed gives the same log. A seed of None puts no errors on the readings, and the log still states those that
    they could have: a design, to be tried with errors of its own. What is not in `noise` is exact.

    The analysis gives the truth back from an exact log: of a level rod or a tilted one, with a spin that stays or
    falls, and of a rod let go from rest where there are more runs than unknowns. With fewer, or with errors, the phase
    of its nutation at the last click is not known, and a run may be early or late by I/(I_zz ψ̇) seconds.
    """
    insist_on_type("truth", truth, Truth | None, "a Truth")
    insist_on_type("design", design, Design | None, "a Design")
    insist_on_type("noise", noise, Mapping, "a mapping of u_… keys to Uncertainty")
    for key in noise:
        insist_on_choice("a key of noise", key, NOISE_KEYS)
    insist_on_type("seed", seed, Integral | None, "a whole number")
    truth, design = truth or Truth(), design or Design()
    random = np.random.default_rng(seed)
    truth = _drawn(truth, design, noise, random, seed)
    runs = happen(truth, design)
    true = _columns(truth, design, runs)
    read = put_errors(true, noise, random, truth.tails) if seed is not None else dict(true)
    # Who stops at a mark that is sighted too far along stops late, by the rate at which the rod goes.
    sighted = np.where(_parts_of_turns(runs), read.pop("turns") / runs.turns, 1.0)
    read["time"] = read["time"] + runs.time * (sighted - 1) + truth.timing_bias
    stated = _stated(truth, noise, runs, set(read))
    return Simulation(_readings(truth, runs, read, stated, seed), truth, runs, stated, seed)


def _drawn(
    truth: Truth, design: Design, noise: Mapping[str, Uncertainty], random: np.random.Generator, seed: int | None
) -> Truth:
    """Fill in what the whole log has in common and the truth leaves open."""
    keys = ("u_imbalance", "u_time_bias", "u_spin_delay", "u_decay_exponent")
    drawn = np.zeros(len(keys))
    if seed is not None:
        # What came later has a stream of its own, so that a seed keeps its log.
        drawn = np.concatenate([random.standard_normal(2), np.random.default_rng([seed, 1]).standard_normal(2)])
    widths = [noise.get(key, Uncertainty()).absolute for key in keys]
    imbalance, bias, delay, bent = (float(width * number) for width, number in zip(widths, drawn, strict=True))
    decay = truth.decay
    if decay is not None and decay.exponent is None:
        decay = replace(decay, exponent=VISCOUS + bent)
    if decay is None or design.spin_reading in (None, "both"):
        delay = 0.0
    return replace(
        truth,
        imbalance=imbalance if truth.imbalance is None else truth.imbalance,
        timing_bias=bias if truth.timing_bias is None else truth.timing_bias,
        spin_delay=delay if truth.spin_delay is None else truth.spin_delay,
        decay=decay,
    )


def _parts_of_turns(runs: Runs) -> NDArray[np.bool_]:
    """Which runs end at another mark than they began."""
    return cast("NDArray[np.bool_]", runs.turns % 1 != 0)


def _columns(truth: Truth, design: Design, runs: Runs) -> dict[str, Floats]:
    """True value of everything that is read, by role."""
    count = len(runs.time)
    columns = {
        "g": np.full(count, truth.g),
        "mass": np.where(runs.mass == 0, np.nan, runs.mass),
        "position": np.where(runs.mass == 0, np.nan, runs.position),
        "time": runs.time,
        "turns": runs.turns,
    }
    if runs.spin_end is None or runs.spin_half is None:
        columns["spin"] = np.abs(runs.spin)
    else:
        start, half, end = (np.abs(spin) for spin in (runs.spin, runs.spin_half, runs.spin_end))
        if design.spin_reading != "half":
            columns |= {"spin_start": start, "spin_end": end}
        if design.spin_reading in ("half", "three"):
            columns["spin"] = half
    if runs.pitch.any():
        columns["pitch"] = runs.pitch
    if runs.pitch.any() or truth.motion == "released":
        columns["transverse_inertia"] = runs.across
    return columns


def _stated(truth: Truth, noise: Mapping[str, Uncertainty], runs: Runs, roles: set[str]) -> dict[str, Uncertainty]:
    """Uncertainties that the log states: all that its readings have, zeros included."""
    absent = {f"u_{role}" for role in ("pitch", "transverse_inertia") if role not in roles}
    if not _parts_of_turns(runs).any():
        absent.add("u_turns")
    if "spin_start" not in roles or "spin" in roles:
        absent.add("u_decay_exponent")
    if "spin_start" in roles:
        absent.add("u_spin_delay")
    stated = {**EXACT, **noise}
    if truth.timing_bias and not stated["u_time_bias"].absolute:
        stated["u_time_bias"] = Uncertainty(UNKNOWN_BIAS_U)
    if truth.decay is None and "u_spin_delay" in stated:
        # A spin that stays is as good a moment later.
        stated["u_spin_delay"] = Uncertainty()
    return {key: u for key, u in stated.items() if key not in absent}


def _readings(
    truth: Truth, runs: Runs, read: dict[str, Floats], stated: dict[str, Uncertainty], seed: int | None
) -> Readings:
    """Write the readings as a student types them, and take them as they stand there."""
    count = len(runs.time)
    texts: dict[str, list[str]] = {}
    for role, values in read.items():
        key = u_keys(role)[-1]
        exact = seed is None or key not in stated
        texts[role] = _typed(values, Uncertainty() if exact else stated[key], role)
    g = read_cell(texts.pop("g")[0], "acceleration", DISPLAY["acceleration"]).value
    texts["mass"] = ["0" if mass == 0 else text for mass, text in zip(runs.mass, texts["mass"], strict=True)]
    texts["turns"] = [_fraction(turns) for turns in runs.turns]
    if runs.spin.min() < 0:
        texts["spin_sense"] = _senses(runs.spin)
    if runs.sense.min() < 0 or not runs.mass.all():
        texts["precession_sense"] = _senses(runs.sense)
    columns = {role: _column(role, column, stated) for role, column in texts.items() if any(column)}
    parts = _parts_of_turns(runs)
    if not parts.all():
        # Whole turns end at the mark where they began: what is stated holds for the others.
        turns = columns["turns"]
        readings = (one if part else replace(one, u=None) for one, part in zip(turns.readings, parts, strict=True))
        columns["turns"] = replace(turns, readings=tuple(readings))
        stated = {key: u for key, u in stated.items() if key != "u_turns"}
    return Readings(
        name="<simulated>",
        sha256="",
        runs=tuple(str(i + 1) for i in range(count)),
        lines=tuple(range(1, count + 1)),
        notes=("",) * count,
        columns=columns,
        constants={"g": g} | ({} if truth.latitude is None else {"latitude": truth.latitude}),
        uncertainties=stated,
        motion="released" if truth.motion == "released" else "steady",
        metadata={"Simulated, not measured": _told(truth, seed)},
    )


def _typed(values: Floats, u: Uncertainty, role: str) -> list[str]:
    """Write readings with as many digits as they deserve: steps of a third of their uncertainty or less."""
    kind = kind_of_role(role)
    shown = [None if math.isnan(value) else from_si(float(value), DISPLAY[kind], kind) for value in values]
    spread = from_si(min((u.at(float(v)) for v in values if not math.isnan(v)), default=0.0), DISPLAY[kind], kind)
    if not spread > 0:
        return ["" if value is None else repr(value) for value in shown]
    # Rounding then adds less than 0.5 % to the uncertainty, so that the one stated is still true.
    digits = -math.floor(math.log10(spread / 3))
    return ["" if value is None else f"{round(value, digits):.{max(digits, 0)}f}" for value in shown]


def _fraction(turns: float) -> str:
    near = Fraction(turns).limit_denominator(100)
    return str(near) if float(near) == turns else repr(float(turns))


def _senses(values: Floats) -> list[str]:
    return ["ccw" if value > 0 else "cw" for value in values]


def _column(role: str, texts: list[str], stated: Mapping[str, Uncertainty]) -> Column:
    """Read one column as the reader would, with what the log says of its uncertainty."""
    kind = kind_of_role(role)
    unit = DISPLAY[kind]
    cells = [read_cell(text, kind, unit) if text else None for text in texts]
    for i, cell in enumerate(cells):
        fault, _ = check_value(role, cell.value) if cell else ("", "")
        if fault:
            message = f"run {i + 1}: {role} {float(texts[i]):.6g} {unit} {fault}"
            hint = "take less noise, a timing bias nearer to 0 s, or more turns"
            if "too large" in fault:
                hint = "take fewer turns, a larger torque, or a timing bias nearer to 0 s"
            raise InputError.of(SIMULATED_VALUE_IMPOSSIBLE, message, hint)
    finest = min((cell.step for cell in cells if cell and cell.step), default=None)
    u = next((stated[key] for key in u_keys(role) if key in stated), None)
    one_reading = role == "transverse_inertia" and len(set(texts)) == 1
    return Column(
        role=role,
        header=f"# {role}" if one_reading else f"{role} [{unit}]" if unit else role,
        unit=unit,
        readings=tuple(
            Reading(cell.value, finest if cell.step else None, u, text) if cell else Reading()
            for cell, text in zip(cells, texts, strict=True)
        ),
        spots=(-1,) * len(texts) if one_reading else tuple(range(len(texts))),
    )


def _told(truth: Truth, seed: int | None) -> str:
    """Say the truth in the log's first line."""
    parts = [f"I_zz = {truth.inertia!r} kg*m^2"]
    if truth.transverse_inertia is not None:
        parts.append(f"I = {truth.transverse_inertia!r} kg*m^2")
    parts += [f"residual torque {truth.imbalance!r} N*m", f"timing bias {truth.timing_bias!r} s", truth.motion]
    if truth.balance_drift:
        parts.append(f"residual torque rising by {truth.balance_drift!r} N*m from first run to last")
    decay = truth.decay
    if decay is not None:
        if decay.time_constant is not None:
            parts.append(f"spin decays with time constant {decay.time_constant!r} s")
        else:
            parts.append(f"{100 * (decay.lost or 0.0):g} % of the spin lost in each run")
        if not decay.viscous:
            law = next((law for law, exponent in EXPONENTS.items() if exponent == decay.exponent), "drag")
            parts.append(f"{law} law of exponent {decay.exponent!r}")
    if truth.spin_delay:
        parts.append(f"half time read {truth.spin_delay!r} s late")
    if truth.tails is not None:
        parts.append(f"clicks of a Student's t with {truth.tails} degrees of freedom")
    if truth.latitude is not None:
        parts.append(f"latitude {truth.latitude!r} rad")
    return ", ".join([*parts, "no errors" if seed is None else f"seed {seed}"])
