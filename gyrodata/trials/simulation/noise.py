"""Errors of simulated readings.

They are the ``u_…`` keys of the log format, shared between runs as in a real lab.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gyrodata.base.errors import InputError, nearest
from gyrodata.measurements import SOURCES
from gyrodata.physics import Floats
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import read_log

# A ruler with millimetres is read to 1 mm/√12 = 0.3 mm; for a real log this follows
# from the digits.
TYPICAL = {
    f"u_{key}": SOURCES[key].default
    for key in (
        "time",
        "time_bias",
        "spin",
        "spin_scale",
        "mass",
        "mass_scale",
        "position",
        "position_zero",
        "pitch",
        "transverse_inertia",
        "spin_delay",
        "decay_exponent",
    )
}
TYPICAL |= {"u_position": Uncertainty(0.0003), "u_turns": SOURCES["angle"].default}
"""The uncertainties that are assumed if a log does not state them."""

EXACT: Mapping[str, Uncertainty] = dict.fromkeys(TYPICAL, Uncertainty()) | {
    "u_spin": Uncertainty(0.0, 1e-12)
}
"""Almost no errors: without any, a run without a torque would have an infinite weight.
"""

NOISE_KEYS = (*TYPICAL, "u_g", "u_imbalance")
"""The uncertainties that a simulated log can have."""

UNREADABLE = "G306"
"""Code of an uncertainty that cannot be read."""

_ERRORS = (
    "time",
    "spin",
    "spin_scale",
    "mass",
    "mass_scale",
    "position",
    "position_zero",
    "pitch",
    "transverse_inertia",
    "g",
    "turns",
)
"""The kinds of errors, in the order in which they are drawn. Readings of one weight or
position share an error."""

_OF_WHOLE_LOG = (
    "spin_scale",
    "mass_scale",
    "position_zero",
    "transverse_inertia",
    "g",
)
"""The kinds of errors that all runs share."""


def put_errors(
    true: Mapping[str, Floats],
    noise: Mapping[str, Uncertainty],
    random: np.random.Generator,
) -> dict[str, Floats]:
    """Add errors to the true values.

    Each error is (absolute + relative × truth) × a standard normal number.

    The random numbers do not depend on the noise, so that a different noise only scales
    the same errors.
    """
    read = {role: np.array(values, dtype=float) for role, values in true.items()}
    for key in _ERRORS:
        u = noise.get(f"u_{key}", Uncertainty())
        of_log = float(random.standard_normal())
        quantity, _, _ = key.partition("_")
        # The spins at the start and at the end are read with one tachometer.
        for role in [role for role in true if role.split("_")[0] == quantity]:
            drawn = np.full(len(true[role]), of_log)
            if key not in _OF_WHOLE_LOG:
                drawn = random.standard_normal(len(true[role]))
            if key in ("mass", "position"):
                _, groups = np.unique(true[role], return_inverse=True)
                drawn = drawn[groups]
            read[role] += (u.absolute + u.relative * true[role]) * drawn
    return read


def read_noise(name: str) -> dict[str, Uncertainty]:
    """Read uncertainties from the ``# u_…: …`` lines of a log; the others are `TYPICAL`.

    Raises
    ------
    InputError
        If the file cannot be read, or does not state any uncertainty of a simulated
        log.
    """
    if not Path(name).is_file():
        raise InputError.named("noise_not_read", name=name)
    readings = read_log(Path(name))
    unread = [fault for fault in readings.diagnostics if fault.code == UNREADABLE]
    if unread:
        raise InputError(unread)
    keys = (*readings.metadata, *readings.uncertainties)
    stated = {key for key in keys if key.startswith("u_")}
    unfit = sorted(stated.difference(NOISE_KEYS))
    if unfit or not stated:
        hint = nearest("".join(unfit[:1]), NOISE_KEYS)
        raise InputError.named("noise_unfit", name=name, hint=hint)
    return {**TYPICAL, **readings.uncertainties}
