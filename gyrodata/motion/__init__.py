"""The complete motion of the top, eqs. (7): exact, by geometric splitting, or by an integrator.

`exact` and the functions next to it are for a symmetric top under gravity without drag; `split` approximates the same
motion by a geometric integrator, and `integrate` includes drag. The state is always e3 and H (`State`).
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
