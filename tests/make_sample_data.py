"""Make sample_data/air_gyroscope.csv from its stated truth; ``python
tests/make_sample_data.py`` writes it anew.
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


if __name__ == "__main__":
    for target in TARGETS:
        target.write_text(make(), encoding="utf-8")
