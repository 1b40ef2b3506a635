"""``gyro simulate``: a log with a known true value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gyrodata.cli.options import Bound, quantity, with_units
from gyrodata.cli.terminal import write_out

if TYPE_CHECKING:
    from gyrodata.simulation import Decay


def simulate(
    inertia: Annotated[
        str, typer.Option("--inertia", metavar="QUANTITY", help="I_zz about the rod.")
    ] = "4.44e-3 kg m^2",
    weights: Annotated[
        str, typer.Option("--weights", metavar="QUANTITIES", help="Masses of the weights; 0g: no weight.")
    ] = "20g,40g,60g",
    position: Annotated[
        str, typer.Option("--position", metavar="QUANTITIES", help="Positions of the weight; negative: the other side.")
    ] = "15cm",
    spins: Annotated[
        str,
        typer.Option("--spins", metavar="QUANTITIES", help="Spins at the start of each run; negative: reversed."),
    ] = "200,400,600rpm",
    turns: Annotated[
        str, typer.Option("--turns", metavar="NUMBERS", help="Number of timed turns, such as 1/3 or 1/3,1.")
    ] = "1",
    pitch: Annotated[
        str, typer.Option("--pitch", metavar="QUANTITIES", help="Angles of the rod above the horizontal.")
    ] = "0deg",
    imbalance: Annotated[
        str | None,
        typer.Option("--imbalance", metavar="QUANTITY", help='Residual torque M0, such as "0.3 mN m". Default: none, '
                     "or drawn from u_imbalance of a noise FILE."),
    ] = None,
    spin_decay: Annotated[
        str | None,
        typer.Option("--spin-decay", metavar="QUANTITY", help='Decay of the spin: its time constant, "600 s", '
                     'or the part lost in each run, "10 %"; the log then has the spin at start and end.'),
    ] = None,
    noise: Annotated[
        str,
        typer.Option("--noise", metavar="none|typical|FILE", help="typical: the default uncertainties; "
                     'FILE: TOML such as u_time = "0.1 s", or lines such as # u_time: 0.1 s.'),
    ] = "typical",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
) -> None:  # fmt: skip
    """Print a simulated log with a known true value, for gyro analyze or any other fit.

    Each weight at each position with each pitch, spin and number of turns is one run. The rod precesses steadily.
    The runs share errors as in a lab: one ruler, one scale, one tachometer, one hand. The log contains its
    uncertainties, and its first line the true values. The same options give the same log.
    """
    from gyrodata import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    truth = simulation.Truth(
        inertia=quantity("--inertia", inertia, "inertia", "above zero"),
        imbalance=None if imbalance is None else quantity("--imbalance", imbalance, "torque"),
        decay=_decay(spin_decay),
    )
    design = simulation.Design(
        masses=_list("--weights", weights, "mass"),
        positions=_list("--position", position, "length"),
        spins=_list("--spins", spins, "rate", "other than zero"),
        turns=_list("--turns", turns, "number", "above zero"),
        pitches=_list("--pitch", pitch, "angle"),
    )
    errors = known[noise] if noise in known else simulation.read_noise(noise)
    write_out(simulation.simulate(truth, design, errors, seed).log)


def _list(option: str, text: str, kind: str, bound: Bound = "") -> tuple[float, ...]:
    return tuple(quantity(option, item, kind, bound) for item in with_units(text))


def _decay(text: str | None) -> Decay | None:
    """Read "600 s", a time constant, or "10 %", the part lost in each run."""
    from gyrodata.simulation import Decay

    if text is None:
        return None
    if text.rstrip().endswith("%"):
        return Decay(lost=quantity("--spin-decay", text.rstrip()[:-1], "number") / 100)
    return Decay(time_constant=quantity("--spin-decay", text, "time", "above zero"))
