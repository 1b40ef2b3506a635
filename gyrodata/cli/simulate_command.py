"""``gyro simulate``: a log with a known true value."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gyrodata.cli.options import list_option, quantity_option
from gyrodata.cli.terminal import write_out


def simulate(
    *,
    inertia: Annotated[
        Any,
        quantity_option(
            "--inertia", "inertia", "above zero", words="I_zz about the rod."
        ),
    ] = "4.44e-3 kg m^2",
    weights: Annotated[
        Any,
        list_option("--weights", "mass", words="Masses of the weights; 0g: no weight."),
    ] = "20g,40g,60g",
    position: Annotated[
        Any,
        list_option(
            "--position",
            "length",
            words="Positions of the weight; negative: the other side.",
        ),
    ] = "15cm",
    spins: Annotated[
        Any,
        list_option(
            "--spins",
            "rate",
            "other than zero",
            words="Spins at the start of each run; negative: reversed.",
        ),
    ] = "200,400,600rpm",
    turns: Annotated[
        Any,
        list_option(
            "--turns",
            "number",
            "above zero",
            "NUMBERS",
            words="Number of timed turns, such as 1/3 or 1/3,1.",
        ),
    ] = "1",
    pitch: Annotated[
        Any,
        list_option(
            "--pitch", "angle", words="Angles of the rod above the horizontal."
        ),
    ] = "0deg",
    imbalance: Annotated[
        Any,
        quantity_option(
            "--imbalance",
            "torque",
            words='Residual torque M0, such as "0.3 mN m". Default: none, or drawn from '
            "u_imbalance of a noise FILE.",
        ),
    ] = None,
    spin_decay: Annotated[
        Any,
        quantity_option(
            "--spin-decay",
            "time",
            "above zero",
            words='Time constant of the decay of the spin, "600 s"; the log then has '
            "the spin at start and end.",
        ),
    ] = None,
    noise: Annotated[
        str,
        typer.Option(
            "--noise",
            metavar="none|typical|FILE",
            help="typical: the default uncertainties; FILE: a log with lines such as "
            "# u_time: 0.1 s.",
        ),
    ] = "typical",
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Seed of the random numbers.")
    ] = 1,
) -> None:
    r"""Print a simulated log with a known true value, for gyro analyze or any other fit.

    Each weight at each position with each pitch, spin and number of turns is one run.
    The rod precesses steadily. The runs share errors as in a lab: one ruler, one scale,
    one tachometer, one hand. The log contains its uncertainties, and its first line the
    true values. The same options give the same log.

    Example:  gyro simulate --inertia "4.44e-3 kg m^2" \
                --weights 20g,40g,60g --position 15cm \
                --spins 200,400,600rpm --turns 1 \
                --seed 1 > log.csv
    """
    from gyrodata.trials import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    truth = simulation.Truth(
        inertia=inertia, imbalance=imbalance, decay_time=spin_decay
    )
    design = simulation.Design(
        masses=weights, positions=position, spins=spins, turns=turns, pitches=pitch
    )
    errors = known[noise] if noise in known else simulation.read_noise(noise)
    write_out(simulation.simulate(truth, design, errors, seed).log)
