"""A log from a known truth: what happens, what is read of it, and the log that a student would have typed.

`Truth` is the gyroscope as it is, `Design` what is done with it. The times follow from the physics alone
(`scene`); errors are then put on the readings (`noise`), each shared by what it is shared by in the lab: one
ruler, one scale, one tachometer, one hand. What comes out is a log like any other (`log`), which says of itself
that it is simulated.
"""

from __future__ import annotations

from gyrodata.simulation.log import Simulation, simulate
from gyrodata.simulation.noise import EXACT, TYPICAL, read_noise
from gyrodata.simulation.scene import Decay, Design, Truth, happen

__all__ = ["EXACT", "TYPICAL", "Decay", "Design", "Simulation", "Truth", "happen", "read_noise", "simulate"]
