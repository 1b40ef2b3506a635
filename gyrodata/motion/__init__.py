"""The whole motion of the top, eqs. (7): exactly, by geometric splitting, or by an integrator.

`exact` and its companions hold for a symmetric top under gravity alone; `split` is the same motion by a geometric
integrator, and `integrate` takes drag too. The state is e3 and H throughout: see `State`.
"""

from gyrodata.motion.exact import (
    Nutation,
    exact,
    find_crossing,
    mean_precession_rate,
    nutation,
    precession_angle,
    time_to_turn,
)
from gyrodata.motion.integrators import METHODS, Path, integrate, split, vector_rates
from gyrodata.motion.orbits import State, Top, energy, released, steady
