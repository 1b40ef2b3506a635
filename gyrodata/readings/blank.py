"""A blank log to fill in, with the weights and spins of the day."""

from __future__ import annotations

from collections.abc import Sequence

from gyrodata.errors import Diagnostic, InputError, register
from gyrodata.quantities import parse_quantity
from gyrodata.units import UnitError, from_si

G506 = register("G506", "error", "template: a value cannot be read", "template --weights 20 --spins fast")


def blank_log(weights: Sequence[str], position: str, spins: Sequence[str]) -> str:
    """Write a log to fill in: each weight with each spin, and a run without a weight.

    Parameters
    ----------
    weights : sequence of str
        Masses with their units, such as ``20 g``; repeats are kept once.
    position : str
        Where the weights sit, such as ``15 cm``.
    spins : sequence of str
        Spins to aim at, such as ``400 rpm``. They go into the notes: what is read off goes into the column.

    Returns
    -------
    str
        CSV text that `read_log` reads without a diagnostic once spin, time and turns are filled in.

    Raises
    ------
    InputError
        A value cannot be read.
    """
    masses = [_shown(text, "mass", "g", "--weights") for text in dict.fromkeys(weights)]
    arm = _shown(position, "length", "cm", "--position")
    aims = [_shown(text, "rate", "rpm", "--spins") for text in dict.fromkeys(spins)]
    lines = [
        "# station: ",
        "# Fill in spin, time and turns of each run: the spin as read at half time, the turns as 1/3, 2/3 or 1.",
        "# Write masses and positions anew, with every digit that the scale and the ruler show.",
        "# More runs: more rows. A run that was not timed: leave its time blank.",
        "mass [g],position [cm],spin [rpm],time [s],turns,note",
    ]
    lines += [f"{mass},{arm},,,,aim at {aim} rpm" for mass in masses for aim in aims]
    middle = aims[len(aims) // 2] if aims else ""
    lines.append(f"0,,,,,no weight on the rod; aim at {middle} rpm" if middle else "0,,,,,no weight on the rod")
    return "\n".join(lines) + "\n"


def _shown(text: str, kind: str, unit: str, option: str) -> str:
    try:
        value = from_si(parse_quantity(text, kind), unit, kind)
    except UnitError as error:
        raise InputError([Diagnostic(G506, "error", f"{option}: {error}", error.hint)]) from None
    if kind != "length" and value <= 0:
        raise InputError([Diagnostic(G506, "error", f'{option}: "{text}" is not above zero')])
    return f"{value:.10g}"
