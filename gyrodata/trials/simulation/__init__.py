"""Simulated logs whose truth is known.

`Truth` contains the true properties of the gyroscope, and `Design` the runs of the lab.
`truth` computes the duration of each run, `noise` adds the errors of the readings, and
`typed_log` writes the log.
"""

from gyrodata.trials.simulation.noise import EXACT, NOISE_KEYS, TYPICAL, read_noise
from gyrodata.trials.simulation.truth import Design, Motion, Runs, Truth, happen
from gyrodata.trials.simulation.typed_log import Simulation, simulate, true_readings
