"""Make sample_data/air_gyroscope.csv and two_days.csv from their stated truth; ``python
tests/make_sample_data.py`` writes them anew.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

SEED = 1
INERTIA = 4.44e-3  # [kg*m^2]: a 4-inch steel ball
IMBALANCE = 6e-4  # [N*m]
BIAS = 0.03  # [s]
G = 9.803  # [m/s^2]
ROOT = Path(__file__).parent.parent
TARGETS = [
    ROOT / "sample_data" / "air_gyroscope.csv",
    ROOT / "gyrodata" / "docs" / "demo.csv",
]

HEAD = f"""\
# Simulated, not measured: I_zz = {INERTIA} kg*m^2, residual torque {IMBALANCE} N*m, timing bias {BIAS} s, seed {SEED}
# noise: 0.1 s a click, tachometer 0.2 % and 0.1 % shared, weights 0.05 % each, ruler zero 0.3 mm, all normal
# station: 3
# ball_mass: 4.31 ± 0.01 kg
# ball_diameter: 101.60 ± 0.05 mm
# g: {G} m/s^2
# u_mass: 0.05 %
# u_position_zero: 0.3 mm
run,mass [g],position [cm],spin [rpm],time [s],turns,precession_sense
"""  # noqa: E501


def make() -> str:
    """Draw the log: 3 weights × 3 spins, and a run without a weight through a twelfth
    of a turn.
    """
    random = np.random.default_rng(SEED)
    tachometer = 1 + 0.001 * random.standard_normal()
    zero = 0.0003 * random.standard_normal()
    lines = []
    for grams, turns in ((20.0, "1/3"), (40.0, "2/3"), (60.0, "1"), (0.0, "1/12")):
        weighed = grams * (1 + 0.0005 * random.standard_normal())
        for rpm in (210, 400, 605) if grams else (400,):
            spin = rpm * (1 + 0.02 * random.standard_normal())
            read = spin * tachometer * (1 + 0.002 * random.standard_normal())
            torque = grams * 1e-3 * G * (0.150 - zero) + IMBALANCE
            numerator, _, denominator = turns.partition("/")
            angle = 2 * math.pi * int(numerator) / int(denominator or 1)
            time = (
                angle * INERTIA * spin * math.pi / 30 / torque
                + BIAS
                + 0.1 * math.sqrt(2) * random.standard_normal()
            )
            load = f"{weighed:.2f},15.00" if grams else "0,"
            lines.append(f"{len(lines) + 1},{load},{read:.1f},{time:.2f},{turns},ccw")
    return HEAD + "\n".join(lines) + "\n"


BALANCES = {"Mon": 6e-4, "Fri": -2.5e-3}  # M0 of each day [N*m]
SEED_OF_DAYS = 2
TWO_DAYS = ROOT / "sample_data" / "two_days.csv"

HEAD_OF_DAYS = f"""\
# Simulated, not measured: I_zz = {INERTIA} kg*m^2, residual torque {BALANCES["Mon"]} N*m on Monday and {BALANCES["Fri"]} N*m on Friday, seed {SEED_OF_DAYS}
# noise: 0.1 s a click, 0.08 s for the hand of a day, tachometer 0.2 % and 0.1 % shared, weights 0.2 % each, ruler zero 1 mm, all normal
# ball_mass: 4.31 ± 0.01 kg
# ball_diameter: 101.60 ± 0.05 mm
# g: {G} m/s^2
day,mass [g],position [cm],spin [rpm],time [s],turns
"""  # noqa: E501


def make_days() -> str:
    """Draw the log of two days with one ball and one ruler: 3 weights × 3 spins a day."""
    random = np.random.default_rng(SEED_OF_DAYS)
    tachometer = 1 + 0.001 * random.standard_normal()
    zero = 0.001 * random.standard_normal()
    masses = {
        grams: grams * (1 + 0.002 * random.standard_normal()) for grams in (20, 40, 60)
    }
    lines = []
    for day, balance in BALANCES.items():
        bias = 0.08 * random.standard_normal()
        arm = 0.150 - zero + random.uniform(-5e-4, 5e-4)
        for grams, mass in masses.items():
            for rpm in (210, 400, 605):
                spin = rpm * (1 + 0.02 * random.standard_normal())
                read = spin * tachometer * (1 + 0.002 * random.standard_normal())
                torque = mass * 1e-3 * G * arm + balance
                time = (
                    2 * math.pi * INERTIA * spin * math.pi / 30 / torque
                    + bias
                    + 0.1 * math.sqrt(2) * random.standard_normal()
                )
                lines.append(f"{day},{grams:.1f},15.0,{read:.0f},{time:.2f},1")
    return HEAD_OF_DAYS + "\n".join(lines) + "\n"


if __name__ == "__main__":
    TWO_DAYS.write_text(make_days(), encoding="utf-8")
    for target in TARGETS:
        target.write_text(make(), encoding="utf-8")
