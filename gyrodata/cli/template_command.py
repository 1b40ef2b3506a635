"""``gyro template``: a log to fill in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from gyrodata.cli.new_table import RunToFill, log_to_fill_in, write_table
from gyrodata.cli.options import list_option, quantity_option
from gyrodata.physics import RPM


def template(
    *,
    weights: Annotated[
        Any,
        list_option("--weights", "mass", "above zero", words="Masses of the weights."),
    ] = "20g,40g,60g",
    position: Annotated[
        Any,
        quantity_option(
            "--position", "length", words="Position of the weights on the rod."
        ),
    ] = "15cm",
    spins: Annotated[
        Any, list_option("--spins", "rate", "above zero", words="Spins to aim for.")
    ] = "200,400,600rpm",
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="Write this file, such as log.xlsx or log.csv.",
        ),
    ] = None,
) -> None:
    r"""Write a blank log: each weight with every spin, and a run without a weight.

    The spins alternate. Without --out, the log is printed as CSV.

    Example:  gyro template --weights 20g,40g,60g \
                --position 15cm --spins 200,400,600rpm \
                --out log.xlsx
    """
    write_table(out or Path("-"), blank_log(weights, position, spins))


def blank_log(weights: Sequence[float], position: float, spins: Sequence[float]) -> str:
    """Write a log to fill in, with each weight at each spin.

    The log also contains a run without a weight, and the first run again.

    The weights take turns, and the second half of the runs is the first half backwards:
    a drift of the balance during the session does not look like an effect of the
    torque.

    Parameters
    ----------
    weights : sequence of float
        Masses [kg]; repeats are kept once.
    position : float
        Position of the weights [m].
    spins : sequence of float
        Spins to aim at [rad/s]. They are in the notes: the column is for the spins that
        are read.

    Returns
    -------
    str
        CSV text that `read_log` reads without a diagnostic when spin, time and turns
        are filled in.
    """
    masses = [*dict.fromkeys(weights)]
    aims = [f"{spin / RPM:.0f}" for spin in dict.fromkeys(spins)]
    half = masses * (len(aims) // 2)
    middle = [*masses * (len(aims) % 2), masses[0]]
    middle.insert((len(middle) + 1) // 2, 0.0)
    runs = []
    used: Counter[float] = Counter()
    for mass in (*half, *middle, *reversed(half)):
        # Each weight begins with another spin.
        turn = masses.index(mass) + used[mass] if mass else len(aims) // 2
        note = f"aim at {aims[turn % len(aims)]} rpm"
        if not mass:
            note = f"no weight on the rod; {note}"
        elif used[mass] == len(aims):
            note = f"the first run once more; {note}"
        used[mass] += 1
        runs.append(RunToFill(mass, position, "", note))
    return log_to_fill_in(runs)
