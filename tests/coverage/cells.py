"""The table: what each cell asks of the 95 % interval, and what it is."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from drawn_labs import INERTIA, Floats, G, Scene, drift_width
from msgspec import Struct
from msgspec.structs import replace
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.fitting import fit, fit_as_stated
from gyrodata.measurements import Measurements

STATED = "# u_time: 0.14 s\n"
OLD = "# u_time_bias: 0.05 s\n# u_spin_delay: 0 s\n"
"""What is true of the labs that err as stated, and was once the default: a hand that is late by 0.05 s, no late reading
of the spin. A silent log allows for more."""


class Outcome(Struct, frozen=True):
    """What many labs of a scene gave."""

    ends: Floats
    """Quantiles of I_zz at 2.5, 15.87, 50, 84.13 and 97.5 % over the true one, shape (labs, 5)."""

    @property
    def covers(self) -> float:
        """Part of the labs whose 95 % interval holds the truth."""
        return float(np.mean((self.ends[:, 0] <= 1) & (self.ends[:, 4] >= 1)))

    @property
    def covers_68(self) -> float:
        return float(np.mean((self.ends[:, 1] <= 1) & (self.ends[:, 3] >= 1)))

    @property
    def length(self) -> float:
        """Mean half-length of the 95 % interval over the true I_zz."""
        return float(np.mean(self.ends[:, 4] - self.ends[:, 0]) / 2)

    @property
    def u(self) -> float:
        """Mean of half the 68.3 % interval."""
        return float(np.mean(self.ends[:, 3] - self.ends[:, 1]) / 2)

    @property
    def bias(self) -> float:
        """Mean of I_zz over the true one, minus 1."""
        return float(np.mean(self.ends[:, 2])) - 1


@cache
def fitted(scene: Scene, labs: int, lines: str | None = None) -> Outcome:
    """Fit labs of a scene as the analyst does whose log has these lines, or the scene's."""
    posteriors = (fit(lab).posterior for lab in _drawn(scene, labs, lines))
    return Outcome(np.array([posterior.quantiles()[0] for posterior in posteriors if posterior]) / INERTIA)


def _drawn(scene: Scene, labs: int, lines: str | None) -> Iterator[Measurements]:
    """Draw labs of a scene, each as the analyst reads it whose log has these lines."""
    design, readings = scene.design(lines), scene.draw(labs)
    for i in range(len(readings["time"])):
        one = {name: values[i] for name, values in readings.items()}
        yield replace(design, **one, torque=one["mass"] * one["position"] * G)


@cache
def plain(scene: Scene, labs: int, lines: str) -> Outcome:
    """The same by plain least squares at the stated widths, with an M0 that may be as large as it likes."""
    ends = []
    for lab in _drawn(scene, labs, lines):
        inertia = fit_as_stated(lab).inertia
        ends.append(inertia.value + np.array([-1.96, -1, 0, 1, 1.96]) * (inertia.u or 0.0))
    return Outcome(np.array(ends) / INERTIA)


class Number(Struct, frozen=True):
    """One number of the table, and what it is asked to be."""

    value: float
    low: float = -math.inf
    high: float = math.inf
    error: float = 0.0
    """Its standard error by chance."""
    digits: str = ".2f"

    @property
    def asked(self) -> str:
        """What is asked, in words."""
        low, high = (format(end, self.digits.replace("+", "")) for end in (self.low, self.high))
        if math.isinf(self.low) and math.isinf(self.high):
            return "-"
        if math.isinf(self.low):
            return f"<= {high}"
        return f">= {low}" if math.isinf(self.high) else f"{low} - {high}"

    @property
    def short(self) -> float:
        """By how many standard errors it is not as asked; 0 if it is."""
        off = max(self.low - self.value, self.value - self.high, 0.0)
        return off / self.error if self.error else math.inf if off else 0.0


Judge = Callable[[int], Number]


class Cell(Struct, frozen=True):
    """One line of the table."""

    name: str
    judge: Judge
    told: Callable[[int], str] = lambda labs: ""
    """What else there is to tell."""
    cannot: str = ""
    """Why no fit can hold it, where none can."""

    def verdict(self, number: Number) -> str:
        """Whether it is as it must be."""
        if not number.short:
            return "holds" if number.asked != "-" else ""
        if self.cannot:
            return "cannot"
        return "by chance?" if number.short < CHANCE else "FAILS"


CHANCE = 2.0
"""A number that is short by fewer standard errors than this may be so by chance."""


def covering(name: str, scene: Scene, low: float, high: float = math.inf, lines: str | None = None) -> Cell:
    """Make a cell of how often the 95 % interval holds the truth [%]."""

    def judge(labs: int) -> Number:
        covers = fitted(scene, labs, lines).covers
        # At 100 % the standard error would be none.
        part = min(max(covers, 0.5 / labs), 1 - 0.5 / labs)
        return Number(100 * covers, low, high, 100 * math.sqrt(part * (1 - part) / labs), ".1f")

    def told(labs: int) -> str:
        out = fitted(scene, labs, lines)
        return (
            f"bias {100 * out.bias:+.2f} %, u {100 * out.u:.2f} %, length {100 * out.length:.2f} %, "
            f"68 %: {100 * out.covers_68:.1f}"
        )

    return Cell(name, judge, told)


Way = tuple[Callable[..., Outcome], str]
"""How labs are fitted, and the lines of the analyst's log."""


def ratio(name: str, scene: Scene, one: Way, other: Way, high: float, cannot: str = "") -> Cell:
    """Make a cell of one mean length of the 95 % interval over another, of the same labs."""

    def judge(labs: int) -> Number:
        a, b = (np.ptp(fitting(scene, labs, lines).ends, axis=1) for fitting, lines in (one, other))
        value = float(a.mean() / b.mean())
        scatter = float((a / a.mean() - b / b.mean()).std()) / math.sqrt(len(a))
        return Number(value, high=high, error=value * scatter, digits=".3f")

    return Cell(name, judge, cannot=cannot)


def cells() -> Iterator[Cell]:
    """All cells, in the order in which they are told."""
    yield from _hands()
    yield from _lengths()
    yield from _balances()
    yield from _balance_tests()
    yield from _other_errors()
    yield from _drifts()


NINE, TWENTY_SEVEN, THREE = Scene(), Scene(repeats=3), Scene(spins=(400,))
FOUR = Scene(masses=(20, 40, 60, 80), spins=(400,))
HEAVY = Scene(masses=(100, 120, 140))


def _hands() -> Iterator[Cell]:
    hands = {f"hand {hand} s": {"hand": hand} for hand in (0.05, 0.14, 0.3, 0.5, 1.0)}
    hands |= {
        # The mean time of these designs is 24 s.
        "hand 1 s x T/mean": {"hand": 0.0, "in_proportion": 1 / 24},
        "hand t3 x 0.3 s": {"hand": 0.3, "tails": 3},
    }
    for runs, scene in (("9 runs", NINE), ("27 runs", TWENTY_SEVEN)):
        for log, lines in (("silent", ""), ("stated", STATED)):
            for hand, error in hands.items():
                yield covering(f"{runs}, {hand}, {log}", replace(scene, lines=lines, **error), 92)
            yield covering(f"{runs}, all as stated, u_time {log}", replace(scene, lines=lines + OLD), 92, 98.5)
    for runs, scene in (("3 runs", THREE), ("4 runs", FOUR)):
        for hand, error in hands.items():
            if "T" not in hand:
                yield covering(f"{runs}, {hand}, silent", replace(scene, **error), 90)


HOPELESS = "hand 0.05 s, new defaults / plain, old widths"
NARROWEST = "a plain fit that states 0.05 s, below, is longer than that too"


def _lengths() -> Iterator[Cell]:
    usual, knowing, stated = (plain, OLD), (fitted, "# u_time: 0.5 s\n"), STATED + OLD
    for runs, scene, most in (("9 runs", NINE, 1.3), ("27 runs", TWENTY_SEVEN, 1.15)):
        far, near = replace(scene, hand=0.5), replace(scene, hand=0.05)
        for name, labs, one, other, high in (
            (" as stated, old widths, silent / plain", scene, (fitted, OLD), usual, 1.08),
            (" as stated, old widths, u_time stated / plain", scene, (fitted, stated), (plain, stated), 1.08),
            (" as stated, new defaults / plain, old widths", scene, (fitted, ""), usual, 1.25),
            (", hand 0.5 s, silent / who states 0.5 s", far, (fitted, ""), knowing, most),
            (", hand 0.5 s, 0.14 s stated / who states 0.5 s", far, (fitted, STATED), knowing, most),
            (", hand 0.05 s, old widths / plain", near, (fitted, OLD), usual, 0.85),
            (f", {HOPELESS}", near, (fitted, ""), usual, 0.85),
            (", the same of a plain fit that states 0.05 s", near, (plain, "# u_time: 0.05 s\n"), usual, math.inf),
        ):  # fmt: skip
            yield ratio(f"{runs}, length{name}", labs, one, other, high, NARROWEST if HOPELESS in name else "")


def _balances() -> Iterator[Cell]:
    scenes = (("9 runs", NINE, 93), ("27 runs", TWENTY_SEVEN, 93), ("3 runs", THREE, 91), ("100/120/140 g", HEAVY, 86))
    for runs, scene, least in scenes:
        for share in (0.0, 0.01, 0.03, 0.05, 0.1, 0.2):
            yield covering(f"{runs}, M0 {100 * share:g} %", replace(scene, imbalance=share), least)
    for runs, scene, _ in scenes:
        yield covering(f"{runs}, M0 Cauchy 2.5 %", replace(scene, imbalance_cauchy=0.025, lines=OLD), 94, 98)
    drawn = replace(HEAVY, imbalance_cauchy=0.025)
    yield ratio("100/120/140 g, length, M0 Cauchy 2.5 % / plain", drawn, (fitted, OLD), (plain, OLD), 0.85)


def _balance_tests() -> Iterator[Cell]:
    tests = {"5 deg": drift_width(5, 60, 400), "0.2 deg": drift_width(0.2, 60, 400)}
    for runs, scene in (
        ("9 runs", NINE), ("27 runs", TWENTY_SEVEN), ("9 runs, thirds", replace(NINE, thirds=True)),
        ("27 runs, thirds", replace(TWENTY_SEVEN, thirds=True)),
    ):  # fmt: skip
        for test, width in tests.items():
            told = replace(scene, lines=f"# balance_drift: {test} in 60 s at 400 rpm\n")
            yield covering(f"{runs}, balance test {test}, true", replace(told, imbalance_u=width), 93)
            for times in (3, 10, 30):
                false = replace(told, imbalance=times * width / told.lightest)
                yield covering(f"{runs}, balance test {test}, false x {times}", false, 93)
        claims = ["", *(f"# balance_drift: {claim} deg in 60 s at 400 rpm\n" for claim in (20, 5, 1, 0.2, 0.05))]

        def tighter(labs: int, scene: Scene = scene, claims: list[str] = claims) -> Number:
            us = [fitted(replace(scene, imbalance_u=0.0), labs, lines).u for lines in claims]
            return Number(max(after / before for before, after in itertools.pairwise(us)), high=1.0, digits=".3f")

        yield Cell(f"{runs}, u with a tighter true test / with the one before", tighter)


def _other_errors() -> Iterator[Cell]:
    for runs, scene in (("9 runs", NINE), ("27 runs", TWENTY_SEVEN)):
        yield covering(f"{runs}, hand late by 0.11 +- 0.04 s", replace(scene, late=0.11, late_u=0.04), 94)
        yield covering(f"{runs}, hand late by 0 +- 0.15 s", replace(scene, late_u=0.15), 92)
    for degrees, least in ((1, 94), (2, 92), (3, 90)):
        yield covering(f"9 runs, thirds, sighting {degrees} deg", Scene(thirds=True, sighting=degrees), least)
    several = {"9 runs": NINE, "27 runs": TWENTY_SEVEN}
    several |= {f"{runs}, thirds": replace(scene, thirds=True) for runs, scene in several.items()}
    for runs, scene in several.items():
        for fall in (0.2, 0.3):
            yield covering(f"{runs}, dry friction, fall {100 * fall:g} %", replace(scene, fall=fall), 94)
        slow = replace(scene, time_constant=300.0)
        yield covering(f"{runs}, tau 300 s, spin read at half time", slow, 92)
        yield covering(f"{runs}, tau 300 s, spin read 2 s late", replace(slow, delay=2.0), 94)
    yield covering("9 runs, tau 300 s, spin read 0 +- 2 s late", replace(NINE, time_constant=300.0, delay_u=2.0), 94)


@cache
def template_order() -> tuple[tuple[int, int], ...]:
    """Weight and spin of the loaded runs in the order in which `gyro template` lists them."""
    rows = CliRunner().invoke(app, ["template"]).stdout.splitlines()
    found = (re.match(r"([\d.]+),.*?(\d+) rpm", row) for row in rows)
    runs = ((round(float(row[1])), int(row[2])) for row in found if row)
    return tuple(run for run in runs if run[0])


def _drifts() -> Iterator[Cell]:
    for sign in (1, -1):
        for name, scene, asked in (
            ("the template's order", replace(NINE, order=template_order(), drift=0.02 * sign), True),
            ("rising order", replace(NINE, drift=0.02 * sign), False),
        ):
            what = f"9 runs, balance drifting by {2 * sign:+d} %, {name}"
            yield covering(what, scene, 92 if asked else -math.inf)

            def pull(labs: int, scene: Scene = scene, asked: bool = asked) -> Number:
                out = fitted(scene, labs)
                return Number(
                    abs(out.bias) / out.u,
                    high=0.3 if asked else math.inf,
                    error=float(out.ends[:, 2].std() / out.u) / math.sqrt(labs),
                )

            yield Cell(f"{what}: bias in u", pull)
