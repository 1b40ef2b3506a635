"""Logs by a grammar: what students type, what they get wrong, and what nobody would
ever write.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

RPM = math.pi / 30
INERTIA = (2e-5, 5e-4, 4.44e-3, 0.05, 2.0)
COUNTS = ("1/3", "2/3", "1", "1/6", "1/2", "2", "2.5", "3", "1/12", "10")

# Unit of a column, and how many of it are one SI unit.
UNITS = {
    "mass": (("g", 1e3), ("kg", 1.0), ("mg", 1e6)),
    "position": (("cm", 1e2), ("mm", 1e3), ("m", 1.0)),
    "spin": (
        ("rpm", 1 / RPM),
        ("rad/s", 1.0),
        ("Hz", 1 / (2 * math.pi)),
        ("об/мин", 1 / RPM),
    ),
    "time": (("s", 1.0), ("min", 1 / 60), ("ms", 1e3)),
    "torque": (("mN*m", 1e3), ("N*m", 1.0)),
    "force": (("N", 1.0),),
    "pitch": (("deg", 180 / math.pi), ("rad", 1.0)),
    "angle": (("deg", 180 / math.pi), ("rad", 1.0)),
    "transverse_inertia": (("kg*m^2", 1.0),),
}
KEYS = {
    "u_time": (
        "0.14 s",
        "0 s",
        "1e-9 s",
        "0.001 s",
        "0.5 s",
        "3 s",
        "1e6 s",
        "2 %",
        "50 %",
    ),
    "u_time_bias": ("0 s", "0.05 s", "0.3 s", "10 s"),
    "u_spin": ("0 %", "1e-6 %", "0.2 %", "5 %", "3 rpm", "60 %"),
    "u_spin_scale": ("0 %", "0.1 %", "10 %", "50 %"),
    "u_mass": ("0 g", "0.2 %", "1 g", "30 %"),
    "u_mass_scale": ("0 %", "0.05 %", "20 %"),
    "u_position": ("0 mm", "1 mm", "2 cm"),
    "u_position_zero": ("0 mm", "0.5 mm", "3 cm"),
    "u_g": ("0 %", "1 %", "0.1 m/s^2"),
    "u_turns": ("0", "0.02"),
    "u_pitch": ("0 deg", "2 deg", "40 deg"),
    "u_transverse_inertia": ("0 %", "30 %"),
    "u_imbalance": ("0 N*m", "1e-9 N*m", "1e-4 N*m", "1 N*m"),
    "g": ("9.803 m/s^2", "981 cm/s^2", "9.81", "1.62 m/s^2"),
    "balance_drift": (
        "5 deg in 60 s at 400 rpm",
        "0.01 deg in 60 s at 400 rpm",
        "90 deg in 1 s at 9 rpm",
    ),
    "balance_tilt": ("3 deg in 10 s", "0.001 deg in 10 s"),
    "motion": ("released", "steady"),
    "transverse_inertia": ("6e-3 kg*m^2", "1e-7 kg*m^2", "3 kg*m^2"),
    "ball_mass": ("4.31 kg", "0 kg"),
    "ball_diameter": ("101.6 mm",),
    "reported_inertia": ("4.4e-3 ± 0.1e-3 kg m^2", "nonsense"),
    "station": ("3", "‮3"),
}
JUNK = (
    "",
    "-",
    "x",
    "0",
    "1e400",
    "-1e-320",
    "1e-300",
    "1e300",
    "nan",
    "inf",
    "12,5",
    "1.234",
    "1/0",
    "1/3",
    "56O",
    "−5",
    "3:05.2",
    "03:36.26",
    "12 ± 0.5",
    "12(3)",
    "76 g",
    "none",
    "=1+1",
    "<b>",
    "\x1b[2J",
    "½",
    "1 000",
    "9" * 400,
    "+",
    "1e",
    "0x10",
    "٣",
    "3-Jan",
    "no weight",
    "± 3",
    "10 ± 0",
    "1e-9",
    "1e9",
)


class Lab(Struct, frozen=True):
    """A table of what was read, SI, with its columns in the order in which they are
    written.
    """

    columns: dict[str, list[float]]
    counts: list[str]
    keys: tuple[tuple[str, str], ...]
    inertia: float
    """The truth [kg*m^2]."""


def draw_lab(random: np.random.Generator, runs: int | None = None) -> Lab:
    """Draw what a lab reads: any weights, spins and counts, in any order."""
    inertia = float(random.choice(INERTIA))
    size = inertia / 4.44e-3
    weights = int(random.integers(1, 6))
    masses = np.sort(
        0.02
        * size ** (2 / 3)
        * (1 + np.arange(weights))
        * random.uniform(0.9, 1.1, weights)
    )
    arm = 0.15 * size ** (1 / 3)
    count = runs or int(random.choice((1, 2, 3, 4, 6, 9, 9, 12, 18, 27, 40, 160, 300)))
    which = (
        np.arange(count) % weights
        if random.random() < 0.5
        else np.sort(random.integers(0, weights, count))
    )
    mass, position = masses[which], np.full(count, arm)
    if random.random() < 0.2:
        position = position * random.choice((-1.0, 1.0), count)
    if random.random() < 0.2:
        position = position * random.choice((0.6, 0.8, 1.0), count)
    spin = (
        RPM
        * random.choice((200.0, 400.0, 600.0), count)
        * random.uniform(0.97, 1.03, count)
    )
    if random.random() < 0.2:
        mass = np.where(random.random(count) < 0.15, 0.0, mass)
    imbalance = 0.03 * masses[0] * 9.803 * arm * random.standard_normal()
    counts = [
        str(c)
        for c in random.choice(COUNTS[: int(random.integers(1, len(COUNTS)))], count)
    ]
    turns = np.array([_number(c) for c in counts])
    total = mass * 9.803 * position + imbalance
    time = 2 * np.pi * turns * inertia * spin / np.abs(
        total
    ) + 0.14 * random.standard_normal(count)
    columns = {
        "mass": mass,
        "position": position,
        "spin": spin * (1 + 0.002 * random.standard_normal(count)),
    }
    columns["time"] = np.maximum(time, 0.05)
    if random.random() < 0.1:
        columns["pitch"] = np.radians(random.uniform(-40, 40, count))
    if random.random() < 0.1:
        columns["torque"] = columns.pop("mass") * 9.803 * columns.pop("position")
    keys = [
        (name, str(random.choice(KEYS[name])))
        for name in KEYS
        if random.random() < 0.08
    ]
    if random.random() < 0.7 and "g" not in dict(keys):
        keys.append(("g", "9.803 m/s^2"))
    return Lab(
        {name: values.tolist() for name, values in columns.items()},
        counts,
        tuple(keys),
        inertia,
    )


def _number(text: str) -> float:
    top, _, bottom = text.partition("/")
    return float(top) / float(bottom or 1)


def slipped(lab: Lab, random: np.random.Generator) -> Lab:
    """Make one slip that a whole log has: a column in another unit than written, one
    count for all, two exchanged.
    """
    columns = {name: list(values) for name, values in lab.columns.items()}
    kind = random.random()
    name = str(random.choice(list(columns)))
    if kind < 0.5:
        factor = float(
            random.choice((1e-3, 0.1, 1 / 60, RPM, 2 * math.pi, 10.0, 60.0, 1e3))
        )
        columns[name] = [value * factor for value in columns[name]]
    elif kind < 0.75:
        return replace(lab, counts=[lab.counts[0]] * len(lab.counts))
    elif kind < 0.9:
        columns[name] = columns[name][::-1]
    else:
        columns[name] = [columns[name][0]] * len(columns[name])
    return replace(lab, columns=columns)


def write(lab: Lab, random: np.random.Generator | None = None, digits: int = 6) -> str:
    """Write a lab as a log; with a generator in any of the units and separators that
    the reader promises.
    """

    def pick(options: Sequence[Any]) -> Any:
        return (
            options[0]
            if random is None
            else options[int(random.integers(len(options)))]
        )

    delimiter = pick((",", ",", ";", "\t"))
    comma = random is not None and delimiter == ";" and random.random() < 0.5
    heads, cells = [], []
    for name, values in lab.columns.items():
        unit, factor = pick(UNITS[name])
        short = (
            f"{name}_{unit}" if unit in ("g", "cm", "s", "rpm") else f"{name} [{unit}]"
        )
        heads.append(pick((f"{name} [{unit}]", f"{name} ({unit})", short)))
        # Zeros at the end are digits that were read.
        how = f"{'#' if digits > 6 else ''}.{digits}g"
        texts = [format(value * factor, how) for value in values]
        cells.append([text.replace(".", ",") if comma else text for text in texts])
    heads.append("turns")
    cells.append([count.replace(".", ",") if comma else count for count in lab.counts])
    lines = [f"# {key}: {value}" for key, value in lab.keys]
    rows = [delimiter.join(row) for row in zip(*cells, strict=True)]
    end = pick(("\n", "\n", "\r\n"))
    return end.join([*lines, delimiter.join(heads), *rows]) + end


def spoiled(text: str, random: np.random.Generator) -> bytes:
    """Do to a text what editors, spreadsheets and tired hands do: cells, lines,
    encodings.
    """
    lines = text.splitlines()
    delimiter = next((d for d in ("\t", ";", ",") if d in lines[-1]), ",")
    for _ in range(int(random.integers(0, 4))):
        at = int(random.integers(len(lines)))
        cells = lines[at].split(delimiter)
        kind = random.random()
        if kind < 0.6:
            cells[int(random.integers(len(cells)))] = str(random.choice(JUNK))
            lines[at] = delimiter.join(cells)
        elif kind < 0.7:
            lines.insert(
                at,
                str(
                    random.choice(
                        ("", "Average", "# u_time: 0 s", "note;note", ",,,,", "Group 3")
                    )
                ),
            )
        elif kind < 0.8:
            lines.insert(at, lines[int(random.integers(len(lines)))])
        elif kind < 0.9:
            lines[at] = delimiter.join(cells[:-1])
        else:
            lines[at] = lines[at][: int(random.integers(len(lines[at]) + 1))]
    whole = "\n".join(lines) + "\n"
    encoding = str(
        random.choice(
            ("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1251", "latin-1")
        )
    )
    data = whole.encode(encoding, "replace")
    return (
        data[: int(random.integers(len(data) + 1))] if random.random() < 0.03 else data
    )


def draw_input(seed: int) -> tuple[bytes, str]:
    """Draw one log: as it should be, with a slip, or spoiled; and the model it is
    analysed with.
    """
    random = np.random.default_rng(seed)
    lab = draw_lab(random)
    if random.random() < 0.4:
        lab = slipped(lab, random)
    text = write(lab, random)
    data = spoiled(text, random) if random.random() < 0.6 else text.encode()
    return data, str(
        random.choice(("auto", "auto", "auto", "horizontal", "steady", "released"))
    )
