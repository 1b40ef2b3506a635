"""The complete motion of the top, eqs. (7).

`release` computes the motion of a rod that is released from rest, from integrals over one nutation. `integrators`
follows any other motion in steps. A top and its state (e3 and H) are defined in `top`.
"""

from gyrodata.motion.integrators import METHODS, integrate, split, vector_rates
from gyrodata.motion.release import Nutation, find_crossing, mean_precession_rate, nutation, time_to_turn
from gyrodata.motion.top import State, Top, released, steady
