"""Students on paper: logs as text, and what each works out from the numbers in them,
with slips or without.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from msgspec import Struct
from simulated_labs import RPM, lab

from gyrodata.grading.grade import Grade, grade_submission
from gyrodata.grading.rubric import default_rubric_text, read_rubric
from gyrodata.grading.submissions import Submission

G = 9.803


class Sheet(Struct, frozen=True):
    """One student's rows as typed: g, cm, rpm, s, turns."""

    mass: np.ndarray
    position: np.ndarray
    spin: np.ndarray
    time: np.ndarray
    turns: np.ndarray

    def log(self, *head: str) -> str:
        lines = [
            f"# g: {G} m/s^2",
            *head,
            "mass [g],position [cm],spin [rpm],time [s],turns",
        ]
        for m, x, n, t, f in zip(
            self.mass, self.position, self.spin, self.time, self.turns, strict=True
        ):
            lines.append(
                f"{m:.2f},{x:.2f},{n:.1f},{t:.2f},"
                + (f"{f:.0f}" if f == round(f) else f"{round(3 * f)}/3")
            )
        return "\n".join(lines) + "\n"


def sheet(
    random: np.random.Generator, turns: float | str = 1.0, **changes: object
) -> Sheet:
    """Draw a lab and type it in; ``turns="mixed"`` times 1/3, 2/3 and 1 turn for the
    three weights.
    """
    measured = lab(random, turns=1.0 if turns == ("mixed") else turns, **changes)  # type: ignore[arg-type]
    part = measured.turns
    time = measured.time
    if turns == "mixed":
        part = np.array([1 / 3, 2 / 3, 1.0])[
            np.unique(measured.mass.round(3), return_inverse=True)[1]
        ]
        time = (measured.time - random.normal(0, 0.14)) * part + random.normal(
            0, 0.14, len(part)
        )
    nominal = 1e3 * measured.mass, 1e2 * np.round(measured.position, 3)
    return Sheet(
        nominal[0].round(2),
        nominal[1].round(2),
        (measured.spin / RPM).round(1),
        time.round(2),
        part,
    )


class Formula(Struct, frozen=True):
    """What a student multiplies the typed numbers with, on the way to torque and rates."""

    mass: float = 1e-3
    position: float = 1e-2
    g: float = G
    spin: float = 2 * math.pi / 60
    precession: float = 2 * math.pi
    use_turns: Callable[[np.ndarray], np.ndarray] = lambda turns: turns
    answer: float = 1.0

    def inertia(self, rows: Sheet, fit: str) -> tuple[float, float]:
        """I_zz and its uncertainty, as a page of a student's report has them."""
        torque = self.mass * rows.mass * self.g * self.position * rows.position
        product = (
            self.precession
            * self.use_turns(rows.turns)
            / rows.time
            * self.spin
            * rows.spin
        )
        if fit == "mean_of_ratios":
            ratios = torque / product
            return self.answer * np.mean(ratios), abs(self.answer) * np.std(
                ratios, ddof=1
            ) / math.sqrt(len(ratios))
        degree = 1 if fit == "with_constant" else 0
        design = np.vander(product, degree + 2)[:, -2:] if degree else product[:, None]
        solution, *_ = np.linalg.lstsq(design, torque, rcond=None)
        left = torque - design @ solution
        covariance = (
            np.linalg.inv(design.T @ design)
            * (left @ left)
            / (len(torque) - design.shape[1])
        )
        return self.answer * float(solution[0]), abs(self.answer) * math.sqrt(
            covariance[0, 0]
        )


RIGHT = Formula()
SLIPS: dict[str, Formula] = {
    "rpm_as_rad_s": Formula(spin=1.0),
    "rad_s_as_rpm": Formula(spin=(2 * math.pi / 60) ** 2),
    "minutes_as_seconds": Formula(spin=2 * math.pi),
    "two_pi_missing": Formula(precession=1.0),
    "two_pi_twice": Formula(precession=(2 * math.pi) ** 2),
    "two_pi_missing_in_both": Formula(precession=1.0, spin=1 / 60),
    "both_in_rpm": Formula(precession=60.0, spin=1.0),
    "g_as_kg": Formula(mass=1.0),
    "kg_as_g": Formula(mass=1e-6),
    "cm_as_m": Formula(position=1.0),
    "cm_as_mm": Formula(position=1e-3),
    "missing_g": Formula(g=1.0),
    "diameter_for_radius": Formula(position=2e-2),
    "radius_halved": Formula(position=0.5e-2),
    "turns_forgotten": Formula(use_turns=np.ones_like),
    "turns_upside_down": Formula(use_turns=lambda turns: 1 / turns),
    "answer_in_g_cm2": Formula(answer=1e7),
    "sign": Formula(answer=-1.0),
    "power_of_ten_1": Formula(answer=10.0),
    "degrees_per_second": Formula(precession=360.0),
    "g_in_cm_s2": Formula(g=980.3),
    "cm2_as_m2": Formula(answer=1e4),
    "exponent_lost": Formula(answer=1e3),
    "exponent_sign_lost": Formula(answer=1e6),
    "rpm_as_rad_s + two_pi_missing": Formula(spin=1.0, precession=1.0),
    "g_as_kg + cm_as_m": Formula(mass=1.0, position=1.0),
    "rpm_as_rad_s + g_as_kg": Formula(spin=1.0, mass=1.0),
    "g_as_kg + turns_forgotten": Formula(mass=1.0, use_turns=np.ones_like),
}
"""How each slip comes about: the raw numbers of the log put into the formula."""


def reported_line(
    value: float, u: float | None, digits: int = 2, unit: str = " kg m^2"
) -> str:
    """Write a report as a careful student does: u with some digits, the value to the
    same place.
    """
    if u is None:
        return f"# reported_inertia: {value:.6g}{unit}"
    power = math.floor(math.log10(abs(value)))
    places = digits - 1 - math.floor(math.log10(u / 10.0**power))
    places = max(places, 0)
    return (
        f"# reported_inertia: {value / 10**power:.{places}f}e{power} ± "
        f"{u / 10**power:.{places}f}e{power}{unit}"
    )


def a_log(seed: int, *head: str) -> str:
    """A log with a right answer."""
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log(*head, reported_line(*RIGHT.inertia(rows, "with_constant")))


STATED = default_rubric_text().replace(
    '[reference]\nfrom = "class"',
    '[reference.all]\ninertia = "4.44e-3 kg m^2"\nu = "0.02e-3 kg m^2"',
)
"""The rubric with a reference of its own, by which a grade does not wait for the class.
"""


def three_logs() -> dict[str, str]:
    """One of each outcome: all points, a slip, and not graded."""
    rows = sheet(np.random.default_rng(3), "mixed")
    good, slip = (
        one.inertia(rows, "with_constant") for one in (RIGHT, SLIPS["rpm_as_rad_s"])
    )
    bad = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,56O,<script>,1/3\n"
    return {
        "good": rows.log(reported_line(*good)),
        "slip": rows.log(reported_line(*slip)),
        "waiting": bad,
    }


@cache
def three_grades() -> dict[str, Grade]:
    with tempfile.TemporaryDirectory() as folder:
        root, found = Path(folder), {}
        for name, text in three_logs().items():
            (root / f"{name}.csv").write_text(text, encoding="utf-8")
            one = Submission(
                name, f"<b>{name}</b> | *", {}, root, log_name=f"{name}.csv"
            )
            found[name] = grade_submission(one, read_rubric(STATED.encode()))
    return found
