"""The whole motion of the top, eqs. (7): exactly, by geometric splitting, or by an integrator."""

from gyrodata.motion.exact import exact, mean_precession_rate, precession_angle, time_to_turn
from gyrodata.motion.states import State, Top, energy, released, steady

__all__ = [
    "State",
    "Top",
    "energy",
    "exact",
    "mean_precession_rate",
    "precession_angle",
    "released",
    "steady",
    "time_to_turn",
]
