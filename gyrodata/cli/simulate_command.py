"""``gyro simulate``: a log from a known truth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import quantity, with_units
from gyrodata.cli.terminal import refuse, write_out
from gyrodata.diagnostics import SIMULATED_OPTIONS_CONTRADICT, TRUTH_CANNOT_BE_WRITTEN

if TYPE_CHECKING:
    from gyrodata.simulation import Decay, DecayLaw, Design
    from gyrodata.units import Uncertainty


def simulate(
    context: typer.Context,
    inertia: Annotated[
        str, typer.Option("--inertia", metavar="QUANTITY", help="I_zz about the rod.")
    ] = "4.44e-3 kg m^2",
    transverse: Annotated[
        str | None,
        typer.Option("--transverse", metavar="QUANTITY", help="I across the rod, about the centre, weight included. "
                     "Default: 1.3 I_zz, and m x^2 of the weight."),
    ] = None,
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
        str, typer.Option("--turns", metavar="NUMBERS", help="Turns that are timed, such as 1/3 or 1/3,1.")
    ] = "1",
    pitch: Annotated[
        str, typer.Option("--pitch", metavar="QUANTITIES", help="Angles of the rod above the horizontal.")
    ] = "0deg",
    motion: Annotated[
        Literal["horizontal", "steady", "released"],
        typer.Option("--motion", help="horizontal: eq. (9); steady: eq. (8); released: the exact motion of a rod let "
                     "go from rest."),
    ] = "steady",
    imbalance: Annotated[
        str | None,
        typer.Option("--imbalance", metavar="QUANTITY", help='Residual torque M0, such as "0.3 mN m". Default: none, '
                     "or drawn from u_imbalance of a noise FILE."),
    ] = None,
    timing_bias: Annotated[
        str | None,
        typer.Option("--timing-bias", metavar="QUANTITY", help='What the stopwatch reads too much, such as "0.05 s". '
                     "Default: drawn from u_time_bias of the noise."),
    ] = None,
    spin_decay: Annotated[
        str | None,
        typer.Option("--spin-decay", metavar="QUANTITY", help='Time constant of the fall of the spin, "600 s", '
                     'or the part lost in each run, "10 %"; the log then has the spin at start and end.'),
    ] = None,
    decay_law: Annotated[
        Literal["viscous", "dry", "turbulent"] | None,
        typer.Option("--decay-law", help="How the spin falls: as in an air film, evenly, or by turbulent drag. "
                     "Default: viscous, or drawn from u_decay_exponent of the noise."),
    ] = None,
    spin_reading: Annotated[
        Literal["half", "both", "three"] | None,
        typer.Option("--spin-reading", help="When a falling spin is read: at half time, at start and end, or at all "
                     "three. Default: both."),
    ] = None,
    delay: Annotated[
        str | None,
        typer.Option("--delay", metavar="QUANTITY", help='How late half time is read, such as "2 s". Default: drawn '
                     "from u_spin_delay of the noise."),
    ] = None,
    sighting: Annotated[
        str | None,
        typer.Option("--sighting", metavar="QUANTITY", help='Error of the angle at each click where a part of a turn '
                     'is timed, such as "1deg". Default: u_turns of the noise.'),
    ] = None,
    tails: Annotated[
        int | None,
        typer.Option("--tails", min=1, help="Heavy tails of the stopwatch: degrees of freedom of a Student's t."),
    ] = None,
    balance_drift: Annotated[
        str | None,
        typer.Option("--balance-drift", metavar="QUANTITY", help='By how much M0 rises from the first run to the '
                     'last, such as "0.6 mN*m".'),
    ] = None,
    latitude: Annotated[
        str | None,
        typer.Option("--latitude", metavar="QUANTITY", help='Where the Earth turns below the rod, such as "42.5deg"; '
                     "it stands still without."),
    ] = None,
    g: Annotated[
        str | None,
        typer.Option("--g", metavar="QUANTITY", help="Free-fall acceleration. Default: normal gravity at the latitude, "
                     "or 9.80665 m/s^2."),
    ] = None,
    noise: Annotated[
        str,
        typer.Option("--noise", metavar="none|typical|FILE", help="typical: the defaults for a log that states "
                     'nothing; FILE: TOML with u_time = "0.1 s" and the like, or lines such as # u_time: 0.1 s.'),
    ] = "typical",
    repeats: Annotated[int, typer.Option("--repeats", min=1, help="How often each run is done.")] = 1,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    truth: Annotated[Path | None, typer.Option("--truth", metavar="FILE", help="Write the truth as JSON.")] = None,
) -> None:  # fmt: skip
    """Print a log from a known truth, for gyro analyze and for trying out any other fit.

    Every weight at every position with every pitch, spin and number of turns is one run. Errors are drawn as they
    are shared in a lab: one ruler, one scale, one tachometer, one hand. The log states its uncertainties, and in
    its first line the truth. The same options give the same log.
    """
    from gyrodata import physics, reporting, simulation

    at = _optional("--latitude", latitude, "angle")
    usual_g = physics.STANDARD_GRAVITY if at is None else float(physics.normal_gravity(at))
    scene = simulation.Truth(
        inertia=quantity("--inertia", inertia, "inertia", positive=True),
        transverse_inertia=_optional("--transverse", transverse, "inertia", positive=True),
        imbalance=_optional("--imbalance", imbalance, "torque"),
        timing_bias=_optional("--timing-bias", timing_bias, "time"),
        g=usual_g if g is None else quantity("--g", g, "acceleration", positive=True),
        motion=motion,
        decay=_decay(spin_decay, decay_law),
        spin_delay=_optional("--delay", delay, "time"),
        balance_drift=_optional("--balance-drift", balance_drift, "torque") or 0.0,
        tails=tails,
        latitude=at,
    )
    design = simulation.Design(
        masses=_list("--weights", weights, "mass"),
        positions=_list("--position", position, "length"),
        spins=_list("--spins", spins, "rate", nonzero=True),
        turns=_list("--turns", turns, "number", positive=True),
        pitches=_list("--pitch", pitch, "angle"),
        repeats=repeats,
        spin_reading=spin_reading,
    )
    done = simulation.simulate(scene, design, _noise(noise) | _sighted(sighting, design), seed)
    log = done.log
    if truth is not None:
        options = {name: value for name, value in context.params.items() if name != "truth"}
        _write(truth, reporting.json_text({**done.to_dict(), "options": options | {"noise": Path(noise).name}}))
    write_out(log)


def _list(option: str, text: str, kind: str, **needs: bool) -> tuple[float, ...]:
    return tuple(quantity(option, item, kind, **needs) for item in with_units(text))


def _optional(option: str, text: str | None, kind: str, **needs: bool) -> float | None:
    return None if text is None else quantity(option, text, kind, **needs)


def _decay(text: str | None, law: DecayLaw | None) -> Decay | None:
    """Understand "600 s", a time constant, or "10 %", the part lost in each run."""
    from gyrodata.simulation import EXPONENTS, Decay

    if text is None:
        if law is not None:
            refuse(
                SIMULATED_OPTIONS_CONTRADICT,
                "--decay-law says how a spin falls, and this one stays",
                'let it fall: --spin-decay "600 s", or "10 %"',
            )
        return None
    exponent = None if law is None else EXPONENTS[law]
    if text.rstrip().endswith("%"):
        lost = quantity("--spin-decay", text.rstrip()[:-1], "number") / 100
        return Decay(lost=lost, exponent=exponent)
    return Decay(time_constant=quantity("--spin-decay", text, "time", positive=True), exponent=exponent)


def _noise(text: str) -> dict[str, Uncertainty]:
    from gyrodata import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    return dict(known[text]) if text in known else simulation.read_noise(text)


def _sighted(text: str | None, design: Design) -> dict[str, Uncertainty]:
    """Turn the error at each click, at the start and at the end, into one of the angle between."""
    from gyrodata.units import Uncertainty

    if text is None:
        return {}
    if all(turns % 1 == 0 for turns in design.turns):
        refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "--sighting is the error of a part of a turn, and whole turns end at the mark where they began",
            "take parts of a turn as well, such as --turns 1/3",
        )
    return {"u_turns": Uncertainty(math.sqrt(2) * quantity("--sighting", text, "angle", positive=True) / (2 * math.pi))}


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
