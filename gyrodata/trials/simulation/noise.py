"""Errors of simulated readings.

They are the ``u_…`` keys of the log format, shared between runs as in a real lab.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from gyrodata.base.errors import InputError, nearest
from gyrodata.base.toml_text import read_toml
from gyrodata.measurements import SOURCES
from gyrodata.physics import Floats
from gyrodata.quantities.notation import parse_uncertainty
from gyrodata.quantities.units import Uncertainty, UnitError
from gyrodata.readings.roles import SPIN_SETS, kind_of_role, u_keys

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


_SPINS = tuple(
    role for role in chain.from_iterable(SPIN_SETS) if "u_spin" in u_keys(role)
)
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
        of_whole_log = key in SOURCES and SOURCES[key].shared_by.startswith("all runs")
        of_log = float(random.standard_normal())
        roles = [key.removesuffix("_scale").removesuffix("_zero")]
        if key.startswith("spin"):
            roles = [*_SPINS]
        for role in roles:
            if role not in true:
                continue
            drawn: Floats | float = of_log
            if not of_whole_log:
                _, groups = np.unique(true[role], return_inverse=True)
                own = random.standard_normal(len(true[role]))
                drawn = own[groups] if key in ("mass", "position") else own
            read[role] += (u.absolute + u.relative * true[role]) * drawn
    return read


def read_noise(path: str | os.PathLike[str]) -> dict[str, Uncertainty]:
    """Read uncertainties from a TOML file, or from the ``# u_…: …`` lines of a log.

    The others are `TYPICAL`.

    Raises
    ------
    InputError
        If the file cannot be read, or does not state any uncertainty of a simulated
        log.
    """
    name = str(path)
    stated = _stated(Path(path), name)
    if not stated:
        raise InputError.named("noise_states_nothing", name=name)
    noise = dict(TYPICAL)
    for key, value in stated.items():
        if key not in NOISE_KEYS:
            fault = "a simulated log does not have this uncertainty"
            raise _unfit(name, key, fault, nearest(key, NOISE_KEYS))
        try:
            noise[key] = parse_uncertainty(str(value), kind_of_role(key))
        except UnitError as error:
            raise _unfit(name, key, str(error), error.hint) from None
        if key.endswith("_scale") and noise[key].absolute:
            hint = 'write the error of a scale in %, such as "0.1 %"'
            raise _unfit(name, key, f'"{value}" is not relative', hint)
    return noise


def _stated(path: Path, name: str) -> Mapping[str, Any]:
    """Return the values of a file as they are written, by key."""
    try:
        data = path.read_bytes()
    except OSError as error:
        why = error.strerror or error
        raise InputError.named("noise_not_read", name=name, why=why) from None
    text = data.decode("utf-8-sig", "replace")
    lines = re.findall(r"^#\s*(u_\w+)\s*:\s*(.*?)\s*$", text, re.MULTILINE)
    if lines:
        return dict(lines)
    return read_toml(data, name, "noise_not_utf8", "noise_no_toml")[1]


def _unfit(name: str, key: str, fault: str, hint: str) -> InputError:
    return InputError.named("noise_unfit", name=name, key=key, fault=fault, hint=hint)
