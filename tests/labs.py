"""Simulated labs with a known truth, as `Measurements`, for the tests of the fit."""

from __future__ import annotations

from functools import cache

import numpy as np
from msgspec.structs import replace

from gyrodata import motion
from gyrodata.fitting import fit
from gyrodata.measurements import Measurements, Source, select

INERTIA = 4.44e-3
G = 9.803
RPM = np.pi / 30


def lab(
    random: np.random.Generator,
    *,
    weights: tuple[float, ...] = (0.020, 0.040, 0.060),
    positions: tuple[float, ...] = (0.150,),
    rpm: tuple[float, ...] = (200.0, 400.0, 600.0),
    repeats: int = 1,
    turns: float = 1.0,
    imbalance: float = 0.0,
    bias: float = 0.0,
    unloaded: bool = False,
    sensed: bool = True,
    noise: float = 1.0,
    u_time: float = 0.14,
    u_spin: float = 0.002,
    u_spin_scale: float = 0.001,
    u_mass: float = 0.002,
    u_zero: float = 0.0005,
) -> Measurements:
    """Draw one lab; ``noise=0`` gives exact readings with the same stated uncertainties."""
    rows = [(w, x, s) for w in weights for x in positions for s in rpm for _ in range(repeats)]
    mass, position, spin = (np.array(column) for column in zip(*rows, strict=True))
    f = np.full(len(rows), turns)
    if unloaded:
        mass, position, spin, f = (np.append(a, v) for a, v in ((mass, 0), (position, 0), (spin, 400), (f, 1 / 12)))
    spin = spin * RPM
    count = len(mass)

    def normal(size: int | None = None) -> np.ndarray:
        return noise * random.standard_normal(size)

    total = mass * G * position + imbalance
    time = 2 * np.pi * f * INERTIA * spin / np.abs(total) + bias + u_time * normal(count)
    read_spin = spin * (1 + u_spin_scale * normal()) * (1 + u_spin * normal(count))
    weighed = mass.copy()
    for weight in np.unique(mass):
        weighed[mass == weight] = weight * (1 + u_mass * normal())
    measured_position = np.where(mass == 0, 0.0, position + u_zero * normal())
    torque = weighed * measured_position * G
    groups = np.where(mass != 0, np.unique(mass, return_inverse=True)[1], -1)
    own, every = np.arange(count), np.zeros(count, dtype=int)
    ones, zeros, nothing = np.ones(count), np.zeros(count), np.full(count, np.nan)
    return Measurements(
        runs=tuple(str(i + 1) for i in range(count)),
        lines=tuple(range(2, count + 2)),
        time=time,
        turns=f,
        spin=read_spin,
        mass=weighed,
        position=measured_position,
        force=nothing,
        given_torque=nothing,
        torque=torque,
        sense=np.sign(total) if sensed else np.sign(torque),
        pitch=zeros,
        transverse_inertia=None,
        spin_start=None,
        spin_end=None,
        g=G,
        timed=True,
        timing_bias_u=0.05,
        imbalance_u=None,
        imbalance_from="",
        sources=(
            Source("time", "time", own, u_time * ones, zeros, "", True, ""),
            Source("spin", "spin", own, zeros, u_spin * ones, "", True, ""),
            Source("spin_scale", "spin", every, zeros, u_spin_scale * ones, "all runs", True, ""),
            Source("mass", "mass", groups, zeros, u_mass * ones, "runs with the same weight", True, ""),
            Source("position_zero", "position", every, u_zero * ones, zeros, "all runs", True, ""),
        ),
        diagnostics=(),
    )


def fitted(labs: list[Measurements]) -> np.ndarray:
    """Fit each lab: quantiles of I_zz at 2.5, 15.87, 50, 84.13 and 97.5 % [kg*m^2], shape (labs, 5)."""
    return np.array([fit(one).posterior.quantiles()[0] for one in labs])  # type: ignore[union-attr]


def let_go(seed: int) -> Measurements:
    """Draw six tight runs of a rod let go from rest."""
    random = np.random.default_rng(seed)
    tight = {"u_time": 0.02, "u_spin": 3e-4, "u_spin_scale": 2e-4, "u_mass": 5e-4, "u_zero": 1e-4}
    drawn = lab(random, weights=(0.04, 0.08), rpm=(300.0, 400.0, 600.0), **tight)  # type: ignore[arg-type]
    across = 6.2e-3 + drawn.mass * 0.15**2
    top, pitch = motion.Top(INERTIA, across, drawn.torque), np.full(6, 0.2)
    time = motion.time_to_turn(top, motion.released(top, drawn.spin, pitch), 2 * np.pi)
    doubt = Source(
        "transverse_inertia", "transverse", np.zeros(6, dtype=int), np.zeros(6), np.full(6, 0.005), "", True, ""
    )
    return replace(
        drawn, time=time + 0.02 * random.standard_normal(6), pitch=pitch, transverse_inertia=across, timing_bias_u=0.01,
        motion="released", sources=(*drawn.sources, doubt),
    )  # fmt: skip


@cache
def scenes() -> dict[str, Measurements]:
    """Labs of every kind that the fit knows, each with its own way through it."""

    def drawn(seed: int, **options: object) -> Measurements:
        return lab(np.random.default_rng(seed), **options)  # type: ignore[arg-type]

    def stated(measured: Measurements) -> Measurements:
        return replace(measured, sources=tuple(replace(one, default=False) for one in measured.sources))

    nine, one_torque = drawn(1, imbalance=1e-3, bias=0.03), drawn(3, weights=(0.04,))
    time, spin, scale, mass, zero = nine.sources
    own, every, nothing = np.arange(9), np.zeros(9, dtype=int), np.full(9, np.nan)

    def source(name: str, quantity: str, groups: np.ndarray, absolute: float, relative: float = 0.0) -> Source:
        sizes = np.full(9, absolute), np.full(9, relative)
        return Source(name, quantity, groups, *sizes, "", True, "")  # type: ignore[arg-type]

    angle, fall = source("angle", "turns", own, 0.004), source("g", "g", every, 3e-4)
    lean = source("pitch", "pitch", own, 0.02), source("transverse_inertia", "transverse", every, 0.0, 0.05)
    heights = np.radians([-25.0, -10.0, 0.0, 3.0, 8.0, 14.0, 20.0, 30.0, 40.0])
    tilted = replace(nine, sources=(*nine.sources, *lean), pitch=heights)
    by_share = replace(time, absolute=0.0 * nine.time, relative=np.full(9, 0.01))
    slips, late = nine.time.copy(), nine.time.copy()
    slips[[2, 7]] *= [2.0, 0.9]
    late[4] += 2.0
    hasty = drawn(1, unloaded=True, sensed=False, imbalance=1e-3)
    ruler = drawn(6, weights=tuple(0.01 * k for k in range(3, 12)), u_zero=0.01)
    return {
        "nine runs": nine,
        "repeats": drawn(2, repeats=2, imbalance=-2e-3),
        "one torque": one_torque,
        "one run": drawn(4, weights=(0.04,), rpm=(400.0,)),
        "two runs": drawn(5, weights=(0.02, 0.06), rpm=(400.0,)),
        "both sides": drawn(6, positions=(0.15, -0.15), imbalance=2e-3),
        "unloaded": drawn(7, unloaded=True, imbalance=6e-4),
        "unloaded, either way": drawn(5, unloaded=True, sensed=False, imbalance=1e-4, u_mass=0.02),
        "unloaded, backwards": drawn(8, unloaded=True, sensed=False, imbalance=-1e-3),
        "unloaded, one way alone": drawn(1, unloaded=True, sensed=False, imbalance=-2e-2),
        "unloaded, the other way alone": drawn(2, unloaded=True, sensed=False, imbalance=2e-2),
        "unloaded, stopped early": replace(hasty, time=hasty.time * np.where(hasty.mass == 0, 0.01, 1.0)),
        "many, unloaded, either way": drawn(1, unloaded=True, sensed=False, imbalance=1e-4, repeats=30, noise=6.0),
        "balanced": replace(nine, balanced=True),
        "balanced, one torque": replace(one_torque, balanced=True),
        "not balanced": replace(one_torque, balanced=False),
        "balance tested": replace(drawn(9), imbalance_u=lambda inertia: 2e-2 * inertia),
        "balance tested wrongly": replace(drawn(10, imbalance=6e-3), imbalance_u=lambda inertia: 1e-5),
        "balance hardly doubted": replace(drawn(11, imbalance=6e-4), imbalance_u=lambda inertia: 1e-4),
        "balance tested well": replace(drawn(9), imbalance_u=lambda inertia: 0.0),
        "widths stated": stated(nine),
        "times alone stated": replace(nine, sources=(replace(time, default=False), *nine.sources[1:])),
        "all but times stated": replace(nine, sources=(time, *stated(nine).sources[1:])),
        "scattered": drawn(12, noise=6.0),
        "scattered, though stated": stated(drawn(12, noise=25.0, weights=(0.05, 0.1))),
        "too good": drawn(13, noise=0.05, repeats=3),
        "short times": drawn(14, weights=(0.1, 0.2), turns=1 / 3, u_time=0.2),
        "very short times": drawn(15, weights=(0.2, 0.4), repeats=2, turns=1 / 3, u_time=0.3),
        "going round": drawn(9, weights=(0.2, 0.4), repeats=2, turns=1 / 3, u_time=0.3),
        "going round and round": drawn(14, weights=(0.1, 0.3), turns=1 / 3, u_time=0.5),
        "many": drawn(16, repeats=20, imbalance=1e-3),
        "slips": replace(nine, time=slips),
        "one late": replace(nine, time=late),
        "a count for a torque": replace(nine, time=nine.time * np.where(own < 3, 2.0, 1.0)),
        "a weak ruler": replace(ruler, turns=np.where(np.isin(np.arange(27), (3, 4)), 1.5, 1.0)),
        "rates": replace(nine, timing_bias_u=0.0, timed=False, sources=(by_share, *nine.sources[1:])),
        "no timing bias": replace(nine, timing_bias_u=0.0),
        "tilted": replace(tilted, transverse_inertia=6.2e-3 + nine.mass * 0.15**2),
        "tilted, I not given": tilted,
        "tilted, runs that turn back": replace(tilted, torque=-nine.torque, mass=-nine.mass, sense=-nine.sense),
        "let go": let_go(1),
        "let go, far off": let_go(5),
        "let go, three runs": select(let_go(2), [0, 2, 5]),
        "let go, two runs": select(let_go(2), [0, 5]),
        "let go, scattered": let_go(6),
        "forces": replace(
            nine, force=nine.mass * G, mass=nothing,
            sources=(time, spin, scale, zero, source("force", "force", own, 2e-3)),
        ),
        "torques": replace(
            nine, given_torque=nine.torque, mass=nothing, position=nothing,
            sources=(time, spin, scale, angle, source("torque", "torque", own // 3, 2e-4)),
        ),
        "the weight spins along": replace(
            tilted, added=0.4 * nine.mass * 0.03**2, slowing=1 + 0.01 * np.cos(own),
            sources=(time, spin, scale, mass, zero, fall, angle, *lean, source("added", "added", every, 0.0, 0.1)),
        ),
    }  # fmt: skip
