"""A log from a known truth: what happens, what is read of it, and the log that a student would have typed.

`Truth` is the gyroscope as it is, `Design` what is done with it. The times follow from the physics alone
(`truth`); errors are then put on the readings (`noise`), each shared by what it is shared by in the lab: one
ruler, one scale, one tachometer, one hand. What comes out is a log like any other (`typed_log`), which says of itself
that it is simulated.
"""

from __future__ import annotations

from gyrodata.simulation.noise import EXACT, TYPICAL, read_noise
from gyrodata.simulation.truth import (
    EXPONENTS,
    Decay,
    DecayLaw,
    Design,
    Runs,
    SpinReading,
    Truth,
)
from gyrodata.simulation.typed_log import Simulation, simulate
