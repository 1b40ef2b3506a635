"""``gyro simulate``: a log from a known truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import quantity, with_units
from gyrodata.cli.terminal import refuse, write_out
from gyrodata.diagnostics import TRUTH_CANNOT_BE_WRITTEN

if TYPE_CHECKING:
    from gyrodata.simulation import Decay
    from gyrodata.units import Uncertainty


def simulate(
    context: typer.Context,
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
    motion: Annotated[
        Literal["horizontal", "steady", "released"],
        typer.Option("--motion", help="horizontal: eq. (9); steady: eq. (8); released: the exact motion of a rod "
                     "released from rest."),
    ] = "steady",
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
    repeats: Annotated[int, typer.Option("--repeats", min=1, help="Number of repeats of each run.")] = 1,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    truth: Annotated[Path | None, typer.Option("--truth", metavar="FILE", help="Write the truth as JSON.")] = None,
) -> None:  # fmt: skip
    """Print a simulated log of a known truth, for gyro analyze or any other fit.

    Each weight at each position with each pitch, spin and number of turns is one run. Errors are shared as in a
    lab: one ruler, one scale, one tachometer, one hand. The log states its uncertainties, and its first line the
    truth. The same options give the same log.
    """
    from gyrodata import simulation
    from gyrodata.reporting.data import json_text

    scene = simulation.Truth(
        inertia=quantity("--inertia", inertia, "inertia", positive=True),
        imbalance=None if imbalance is None else quantity("--imbalance", imbalance, "torque"),
        motion=motion,
        decay=_decay(spin_decay),
    )
    design = simulation.Design(
        masses=_list("--weights", weights, "mass"),
        positions=_list("--position", position, "length"),
        spins=_list("--spins", spins, "rate", nonzero=True),
        turns=_list("--turns", turns, "number", positive=True),
        pitches=_list("--pitch", pitch, "angle"),
        repeats=repeats,
    )
    done = simulation.simulate(scene, design, _noise(noise), seed)
    if truth is not None:
        options = {name: value for name, value in context.params.items() if name != "truth"}
        _write(truth, json_text({**done.to_dict(), "options": options | {"noise": Path(noise).name}}))
    write_out(done.log)


def _list(option: str, text: str, kind: str, **needs: bool) -> tuple[float, ...]:
    return tuple(quantity(option, item, kind, **needs) for item in with_units(text))


def _decay(text: str | None) -> Decay | None:
    """Understand "600 s", a time constant, or "10 %", the part lost in each run."""
    from gyrodata.simulation import Decay

    if text is None:
        return None
    if text.rstrip().endswith("%"):
        return Decay(lost=quantity("--spin-decay", text.rstrip()[:-1], "number") / 100)
    return Decay(time_constant=quantity("--spin-decay", text, "time", positive=True))


def _noise(text: str) -> dict[str, Uncertainty]:
    from gyrodata import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    return dict(known[text]) if text in known else simulation.read_noise(text)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        refuse(
            TRUTH_CANNOT_BE_WRITTEN,
            f"the truth cannot be written to {path}: {reason}",
            "choose another file with --truth",
        )
