"""The complete motion of the top, eqs. (7).

`release` computes the motion of a rod that is released from rest, from integrals over one nutation. `integrators`
defines a top and its state (e3 and H), and follows any other motion in steps.
"""

from gyrodata.motion.integrators import METHODS, State, Top, integrate, released, split, steady, vector_rates
from gyrodata.motion.release import Nutation, find_crossing, mean_precession_rate, nutation, time_to_turn
