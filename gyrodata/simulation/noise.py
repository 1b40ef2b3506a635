"""How readings err: the ``u_…`` of the log format, each shared by what it is shared by in the lab."""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from msgspec import Struct

from gyrodata.diagnostics import NOISE_CANNOT_BE_READ
from gyrodata.errors import Diagnostic, InputError
from gyrodata.measurements import SOURCES
from gyrodata.physics import Floats
from gyrodata.quantities import parse_uncertainty
from gyrodata.readings import SPIN_SETS, kind_of_role, u_keys
from gyrodata.units import Uncertainty, UnitError

# A ruler with millimetres is read to 1 mm/√12 = 0.3 mm; the positions of a log have what they are rounded by.
TYPICAL: Mapping[str, Uncertainty] = {
    f"u_{key}": Uncertainty(0.0003) if key == "position" else SOURCES[key].default
    for key in (
        "time", "time_bias", "spin", "spin_scale", "mass", "mass_scale", "position", "position_zero", "pitch",
        "transverse_inertia", "spin_delay", "decay_exponent",
    )
    if key in SOURCES
} | {"u_turns": SOURCES["angle"].default}  # fmt: skip
"""What a log is taken to mean where it says nothing."""

EXACT: Mapping[str, Uncertainty] = dict.fromkeys(TYPICAL, Uncertainty()) | {"u_spin": Uncertainty(0.0, 1e-12)}
"""No errors but those of sixteen digits: with none at all, a run without a torque would weigh infinitely much."""

NOISE_KEYS = (*TYPICAL, "u_g", "u_imbalance")
"""All that a simulated log can err in."""


class _Error(Struct, frozen=True):
    """One kind of error: which readings it is in, and which of them have it in common."""

    key: str
    roles: tuple[str, ...]
    common: Literal["run", "value", "log"]
    """"run": none; "value": equal true values, as of one weight used in three runs; "log": all."""


_SPINS = tuple(role for roles in SPIN_SETS for role in roles if "u_spin" in u_keys(role))
_ERRORS = (
    _Error("u_time", ("time",), "run"),
    _Error("u_spin", _SPINS, "run"),
    _Error("u_spin_scale", _SPINS, "log"),
    _Error("u_mass", ("mass",), "value"),
    _Error("u_mass_scale", ("mass",), "log"),
    _Error("u_position", ("position",), "value"),
    _Error("u_position_zero", ("position",), "log"),
    _Error("u_pitch", ("pitch",), "run"),
    _Error("u_transverse_inertia", ("transverse_inertia",), "log"),
    _Error("u_g", ("g",), "log"),
    _Error("u_turns", ("turns",), "run"),
)


def put_errors(
    true: Mapping[str, Floats],
    noise: Mapping[str, Uncertainty],
    random: np.random.Generator,
    tails: int | None = None,
) -> dict[str, Floats]:
    """Read n runs once: the truth plus (absolute + relative × truth) × a standard normal number for each error.

    The same numbers are drawn whatever the noise, so that another noise gives the same errors, scaled. With `tails` the
    stopwatch's are of a Student's t with so many degrees of freedom.
    """
    read = {role: np.array(values, dtype=float) for role, values in true.items()}
    for error in _ERRORS:
        u = noise.get(error.key, Uncertainty())
        of_log = float(random.standard_normal())
        for role in error.roles:
            if role not in true:
                continue
            values = true[role]
            if error.common == "log":
                read[role] += (u.absolute + u.relative * values) * of_log
                continue
            _, groups = np.unique(values, return_inverse=True)
            if tails is not None and error.key == "u_time":
                drawn = random.standard_t(tails, len(values))
            else:
                drawn = random.standard_normal(len(values))
            read[role] += (u.absolute + u.relative * values) * (drawn if error.common == "run" else drawn[groups])
    return read


def read_noise(path: str | os.PathLike[str]) -> dict[str, Uncertainty]:
    """Read the uncertainties of a TOML file, or of the ``# u_…: …`` lines of a log; the rest is `TYPICAL`."""
    faults = []
    noise = dict(TYPICAL)
    for key, text in _texts(Path(path)).items():
        if key not in NOISE_KEYS:
            close = difflib.get_close_matches(key, NOISE_KEYS, n=2)
            hint = f"did you mean {' or '.join(close)}?" if close else f"keys are: {', '.join(NOISE_KEYS)}"
            faults.append(
                Diagnostic(
                    NOISE_CANNOT_BE_READ, "error", f"--noise {key}: a simulated log has no such uncertainty", hint
                )
            )
            continue
        try:
            noise[key] = parse_uncertainty(text, kind_of_role(key))
        except UnitError as error:
            faults.append(Diagnostic(NOISE_CANNOT_BE_READ, "error", f"--noise {key}: {error}", error.hint))
            continue
        if key.endswith("_scale") and noise[key].absolute:
            message = f'--noise {key}: "{text}" is not a share'
            faults.append(
                Diagnostic(
                    NOISE_CANNOT_BE_READ, "error", message, 'the error of a whole scale is in %, such as "0.1 %"'
                )
            )
    if faults:
        raise InputError(faults)
    return noise


def _texts(path: Path) -> dict[str, str]:
    """Values by key, as written."""
    try:
        with path.open("rb") as file:
            content = file.read(10_000_000).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "it is not UTF-8 text"
        message = f"--noise {str(path)!r} cannot be read: {reason}"
        hint = 'write "none", "typical" or the name of a file'
        raise InputError.of(NOISE_CANNOT_BE_READ, message, hint) from None
    lines = re.findall(r"^#\s*(u_\w+)\s*:\s*(.*?)\s*$", content, re.MULTILINE)
    try:
        table = tomllib.loads(content)
    except (ValueError, RecursionError) as error:
        if lines:
            return dict(lines)
        message = f"--noise {str(path)!r} is no TOML and has no lines such as # u_time: 0.1 s ({error})"
        raise InputError.of(NOISE_CANNOT_BE_READ, message, 'in TOML, write: u_time = "0.1 s"') from None
    texts = {key: str(value) for key, value in table.items()} or dict(lines)
    if not texts:
        message = f"--noise {str(path)!r} states no uncertainty"
        raise InputError.of(NOISE_CANNOT_BE_READ, message, 'write: u_time = "0.1 s"')
    return texts
