"""The models of how a rod moves while it is timed, one class for each.

The fit contains the equation of steady precession: eq. (9), or eq. (8) with a pitch. A
model gives the mean rate of a rod that moves in another way, the errors that exist only
then, and the words for users. `MODELS` is the list of all
models, the simplest first. A new model is a subclass in this list. The fit, the choice
of the model, the tables and the pages ask the model, and never for its name.

A `Motion` contains the models of one fit. Their corrections multiply.

Words for a model, as they are used here and in `gyrodata.judging.changes`:

stated
    The log says that the rod moved so.
asked
    The user chose the model.
silent
    The log does not say how the rod moved. *Supposed* readings, those of a typical rod,
    then give the size of the effect; the fit never uses them.
offered
    The model is stated, or the log is silent and the motion is *possible*.
needed
    The model is offered, and changes I_zz by too much to be left out.
used
    The model is in the fit; its effect is then *kept*.
assumed
    The model is used, and the log is silent.
slowing
    The rate by the equation in the fit, over the mean rate of the model.

The *start* is how the rod began to move, the line ``# motion:`` of the log: `GUIDED` or
`FROM_REST`. It is one fact that models ask for. A guided rod needs no correction, so
that this start belongs to `Horizontal`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final, Literal

import numpy as np
from msgspec import Struct

from gyrodata.physics import (
    EARTH_ROTATION,
    Floats,
    click_error,
    harmonic_mean_spin,
    precession_rate,
    sag_size,
)
from gyrodata.physics.motion import (
    Top,
    mean_precession_rate,
    total_spin,
)

GUIDED: Final = "steady"
FROM_REST: Final = "released"
"""The words of the line ``# motion:`` for a rod that was guided until it precessed
steadily, and for one that was released from rest: how a rod began to move. The model
"steady" is something else, eq. (8)."""

ModelName = Literal[
    "auto",
    "horizontal",
    "steady",
    "released",
]
"""The names that a user can choose from, for type checkers; `names` lists them."""

LEVEL_TO = math.radians(2.0)
"""How far from level [rad] a rod may be if nobody measured it: the default standard
uncertainty of a pitch."""

STEEP = math.radians(45)
FALLEN = math.radians(52)
"""A released rod that sags by more than the first angle hits the cup of the ball. No
answer is given from the second angle on: without a fit the sag is known to some degrees
only."""


class TimedRuns(Struct, frozen=True, eq=False):
    """The readings of n runs for a model of motion; arrays have shape (n,)."""

    time: Floats
    """Timed interval [s]."""
    turns: Floats
    """Revolutions of precession in that time [1]."""
    spin: Floats
    """Mean spin relative to the rod's frame [rad/s]."""
    pitch: Floats
    """Rod above the horizontal [rad]; 0 if the log does not say."""
    sense: Floats
    """Sign of φ̇ψ̇, the rate of precession times the spin: +1 if both have the same
    sign; 0 if it is unknown."""
    transverse_u: float
    """Relative standard uncertainty of I [1]."""
    spin_start: Floats | None = None
    """[rad/s]; None if it was not read."""
    spin_end: Floats | None = None
    """[rad/s]; None if it was not read."""
    total_spin: Floats | None = None
    """Total spin [rad/s]; None if the tachometer follows the rod."""
    direction: Floats | None = None
    """Sign of φ̇ alone: +1 counterclockwise, −1 clockwise seen from above, 0 if it is
    unknown; None if no run has a direction."""
    latitude: float | None = None
    """[rad]; None if the log does not say."""
    start: str | None = None
    """The line ``# motion:`` of the log; None if the log does not say."""
    lines: Mapping[str, str] = {}
    """Every line ``# key: value`` of the log."""


class ModelError(Struct, frozen=True, eq=False):
    """An error of the readings that exists only with one model of motion."""

    name: str
    """Its line in the budget."""
    quantity: Literal["time", "turns"]
    size: Floats
    """Standard uncertainty: of a time [s], of turns over the turns [1]; shape (n,)."""
    described: str
    """Where the size comes from, in words."""
    shared_by: str = ""
    """In words; "" if every run has its own error."""


class MotionModel(Struct, frozen=True):
    """How a rod may move, and what this changes.

    The attributes are its names and words; the methods are its physics. A subclass
    replaces what differs.
    """

    name: ClassVar[str] = ""
    """Its name in the JSON and in the option ``--model``; "" if the name of a fit is
    that of another model in it."""
    words: ClassVar[str] = ""
    """The model for users, after "by": "eq. (8), a tilted rod"."""
    effect: ClassVar[str] = ""
    """Name in the JSON of the effect that it takes into account."""
    effect_words: ClassVar[str] = ""
    """The effect for users."""
    start: ClassVar[str] = ""
    """What the line ``# motion:`` says of such a rod: `GUIDED` or `FROM_REST`."""
    tilted: ClassVar[bool] = False
    """True if the fit uses eq. (8) with each run's pitch, not eq. (9)."""
    sags: ClassVar[bool] = False
    """True if the rod starts from rest, and sags before it precesses."""
    always: ClassVar[bool] = False
    """True if the effect exists in every lab, whether the log states it or not."""
    source_words: ClassVar[Mapping[str, str]] = {}
    """Names for users of the errors that it adds."""
    messages: ClassVar[tuple[str, str] | None] = None
    """The messages for a log that is silent about the motion: if the model is assumed,
    and if it is not used."""

    def is_stated(self, runs: TimedRuns) -> bool:
        """Return whether a log states that its rods moved in this way."""
        return False

    def is_listed(self, runs: TimedRuns) -> bool:
        """Return whether the table of effects has a row for it if it is not used.

        A model of a special bench returns `is_stated` of the log.
        """
        return True

    def is_silent(self, runs: TimedRuns) -> bool:
        """Return whether a log does not say if its rods moved in this way.

        `is_possible` and the size of the effect then decide whether it is assumed.
        """
        return False

    def is_possible(self, top: Top, runs: TimedRuns) -> bool:
        """Return whether the rods can have moved in this way if the log is silent."""
        return True

    def supposed(self, runs: TimedRuns) -> dict[str, Any]:
        """Return readings of a typical rod that moves so, for a log without them.

        Only the size of the effect uses them, never the fit. The keys are fields of
        `gyrodata.measurements.Measurements`.
        """
        return {}

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        """Say why the effect is in the fit of a log, or is not.

        Parameters
        ----------
        runs : TimedRuns
        kept : bool
            Whether the effect is in the fit. It is not if its readings are supposed: a
            user who asks for "steady" without a pitch in the log gets a level rod.
        as_asked : str
            ", as asked" if the user chose the models of the fit, else "".
        """
        raise NotImplementedError

    def is_corrected(self, runs: TimedRuns) -> bool:
        """Return whether the mean rate differs from that of the equation in the fit."""
        return True

    def mean_rate(self, top: Top, runs: TimedRuns, steady_rate: Floats) -> Floats:
        """Compute the mean rate of precession [rad/s], shape (n,).

        `steady_rate` is the rate by the equation in the fit [rad/s].
        """
        return steady_rate

    def errors(
        self, top: Top, runs: TimedRuns, slowing: Floats
    ) -> Iterator[ModelError]:
        """Yield the errors that exist only with this model.

        `slowing` is the steady rate over `mean_rate` [1], shape (n,): 1.01 if the rod
        precesses 1 % more slowly than steadily. It is that of this model alone.
        """
        return iter(())


class Horizontal(MotionModel, frozen=True):
    """Steady precession of a level rod, eq. (9): no correction."""

    name = "horizontal"
    words = "eq. (9), a level rod"
    start = GUIDED

    def is_corrected(self, runs: TimedRuns) -> bool:
        """Return False: the fit contains eq. (9)."""
        return False


class Steady(MotionModel, frozen=True):
    """Steady precession of a tilted rod, eq. (8)."""

    name = "steady"
    words = "eq. (8), a tilted rod"
    effect = "tilt"
    effect_words = "tilted rod, eq. (9) for eq. (8)"
    tilted = True

    def is_stated(self, runs: TimedRuns) -> bool:
        """Return whether a rod of the log is not level."""
        return bool(runs.pitch.any())

    def supposed(self, runs: TimedRuns) -> dict[str, Any]:
        """Return a typical pitch for a log without one."""
        if runs.pitch.any():
            return {}
        return {"pitch": np.full(len(runs.time), LEVEL_TO)}

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        """Say which equation is used."""
        if not runs.pitch.any():
            return "no pitch in the log; this is for 2° off level"
        return f"{'eq. (8)' if kept else 'eq. (9)'} is used{as_asked}"

    def is_corrected(self, runs: TimedRuns) -> bool:
        """Return whether the log has spins at start and end; else eq. (8) is all."""
        return runs.spin_start is not None

    def mean_rate(self, top: Top, runs: TimedRuns, steady_rate: Floats) -> Floats:
        """Compute the mean of eq. (8)'s rate over a viscous decay of the spin [rad/s].

        The method is Gauss-Legendre quadrature.
        """
        if runs.spin_start is None or runs.spin_end is None:
            return steady_rate
        points, weights = np.polynomial.legendre.leggauss(8)
        decay = np.log(runs.spin_end / runs.spin_start)
        moments = 0.5 * (points[:, None] + 1)  # time over the timed interval [1]
        spins = runs.spin_start * np.exp(moments * decay)
        # `runs.spin` is the mean of the spin that eq. (9) needs. If the spin was also
        # read at half time, it differs a little from the mean of this decay: with this
        # factor, a level rod still gets exactly eq. (9).
        mean_spin = harmonic_mean_spin(runs.spin_start, runs.spin_end)
        spins *= runs.spin / mean_spin
        rates = precession_rate(
            top.torque, spins, top.inertia, top.transverse_inertia, runs.pitch
        )
        return np.asarray(0.5 * weights @ rates)


class Released(MotionModel, frozen=True):
    """A rod that is released from rest, by the exact motion.

    It sags, nutates, and has a smaller mean rate than in steady precession.
    """

    name = "released"
    words = "the mean rate of a rod released from rest"
    effect = "release"
    effect_words = "nutation after letting go"
    start = FROM_REST
    sags = True
    source_words = {
        "nutation": "nutation at the last button press",
        "release": "transverse inertia, in the nutation",
    }

    def is_stated(self, runs: TimedRuns) -> bool:
        """Return whether the log says that the rod was released."""
        return runs.start == self.start

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        """Say whether the rod counts as released."""
        if kept:
            return f"the mean rate of a rod released from rest is used{as_asked}"
        if runs.start not in (None, self.start):
            return (
                f"{runs.start}, as the log says; this is for a rod released from rest"
            )
        if runs.start is None:
            return (
                'assumed steady; this is for a rod released from rest ("# motion: '
                'released" in the log)'
            )
        return f"released, as the log says; computed as steady{as_asked}"

    def mean_rate(self, top: Top, runs: TimedRuns, steady_rate: Floats) -> Floats:
        """Compute the mean rate by the exact motion [rad/s], shape (n,).

        To second order in δ = I M/(I_zz ψ̇)² a level rod is slower by (2 − 3/2 I_zz/I)
        δ² if the spin was read on the rod, and by 2δ² if ψ̇ is the total spin.
        """
        total = conserved_spin(top, runs)
        rate = mean_precession_rate(top, total, runs.pitch)
        return np.asarray(rate)

    def errors(
        self, top: Top, runs: TimedRuns, slowing: Floats
    ) -> Iterator[ModelError]:
        """Yield the unknown phase of the nutation, and the doubt about I."""
        click = click_error(runs.spin, top.inertia, top.transverse_inertia)
        click_u = click / math.sqrt(2)
        yield ModelError("nutation", "time", click_u, "its phase at the last click")
        # The reduction of the mean rate is proportional to the square of I.
        slowing_u = 2 * runs.transverse_u * np.abs(slowing - 1)
        described = "the doubt about I in the mean rate"
        yield ModelError("release", "turns", slowing_u, described, "all runs")


def conserved_spin(top: Top, runs: TimedRuns) -> Floats:
    """Return the total spin, which is conserved, of rods released from rest [rad/s]."""
    if runs.total_spin is not None:
        return runs.total_spin
    total = total_spin(top, runs.spin, runs.pitch)
    return np.asarray(total)


def _released_sag(top: Top, runs: TimedRuns, spin: Floats) -> Floats:
    """Compute the greatest sag of rods released from rest [rad]; 0 without a torque."""
    across = top.transverse_inertia
    with np.errstate(divide="ignore", invalid="ignore"):
        sag = sag_size(top.torque, spin, top.inertia, across, runs.pitch)
    return np.where(top.torque != 0, sag, 0.0)


PART_RELEASED = 0.5
PART_U = 0.4
"""Part of the effect of a release, and its standard uncertainty, if the log does not
say how the rod was started. A rod that gets a push of the share k of the steady rate
shows (1 − k)(4 − 2k − (3 − k)q)/(4 − 3q) of the effect, with q = I_zz/I, to second
order in I φ̇/(I_zz ψ̇) (expand `gyrodata.physics.motion.mean_precession_rate`): all of
it without a push, and none of it with the steady rate. Nobody knows k, and a hand can
also hold the rod back a little (k < 0): the part is taken as 0.5 ± 0.4, so that none
and all of the effect are 1.25 u away."""


class Pushed(Released, frozen=True):
    """A rod that is released with an unknown push: the start of a silent log.

    It has the name and the effect of `Released`, which is before it in `MODELS` and so
    stands for both: a user who asks for "released", and the table of effects, get a rod
    without a push. A push lessens the sag, so that no log is refused because of it.
    """

    words = "half the effect of a release from rest, for a light push"
    start = ""
    sags = False
    source_words = {
        "habit": "push of the hand when the rod is released",
        "push": "push of the hand in each run",
    }
    messages = ("release_assumed", "release_not_told")

    def is_stated(self, runs: TimedRuns) -> bool:
        """Return False: no log states the size of a push."""
        return False

    def is_silent(self, runs: TimedRuns) -> bool:
        """Return whether the log does not say how the rod was started."""
        return runs.start is None

    def is_possible(self, top: Top, runs: TimedRuns) -> bool:
        """Return whether no rod would have fallen if it had been released from rest."""
        # The spin that is read while a rod sags is a little larger than the one that is
        # conserved, which takes longer to compute: up to half of the limit, the sag by
        # the conserved spin is below the limit too.
        sag = _released_sag(top, runs, runs.spin)
        if np.all(sag < FALLEN / 2):
            return True
        total = conserved_spin(top, runs)
        sag = _released_sag(top, runs, total)
        return bool(np.all(sag < FALLEN))

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        """Say what is assumed."""
        return (
            "a release with a light push is assumed, because the log does not say how "
            "the rod was started"
        )

    def mean_rate(self, top: Top, runs: TimedRuns, steady_rate: Floats) -> Floats:
        """Compute the mean rate with a part of the effect of a release [rad/s]."""
        mean = Released.mean_rate(self, top, runs, steady_rate)
        effect = ratio(steady_rate, mean) - 1
        slowing = 1 + PART_RELEASED * effect
        return np.asarray(steady_rate / slowing)

    def errors(
        self, top: Top, runs: TimedRuns, slowing: Floats
    ) -> Iterator[ModelError]:
        """Yield the errors of a released rod, and the size of the push."""
        yield from Released.errors(self, top, runs, slowing)
        effect = np.abs(slowing - 1) / PART_RELEASED
        # One half of the variance is the habit of the hand, the other half differs from
        # run to run.
        push = PART_U * effect / math.sqrt(2)
        described = "0.5 ± 0.4 of the effect"
        hand = "all runs (the same hand)"
        yield ModelError("habit", "turns", push, described, hand)
        yield ModelError("push", "turns", push, described)


class Earth(MotionModel, frozen=True):
    """The floor that turns with the Earth while a run is timed."""

    effect = "earth"
    effect_words = "the Earth's rotation"
    always = True

    def is_stated(self, runs: TimedRuns) -> bool:
        """Return whether the log states the latitude and the direction of each run."""
        if runs.latitude is None or runs.direction is None:
            return False
        return bool(runs.direction.all())

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        """Say whether the floor counts as turning, and at which latitude."""
        if kept:
            return "the angles are counted against the stars"
        if self.is_stated(runs):
            return "at the log's latitude"
        if runs.latitude is None:
            return "at most, at a pole"
        return "at the log's latitude, its sign unknown"

    def mean_rate(self, top: Top, runs: TimedRuns, steady_rate: Floats) -> Floats:
        """Compute the mean rate against the turning floor [rad/s], shape (n,).

        Without a latitude, the rate at a pole shows how large the effect is at most.
        """
        # Counterclockwise is positive.
        latitude = math.pi / 2 if runs.latitude is None else runs.latitude
        floor = EARTH_ROTATION * math.sin(latitude)
        # A run without a direction turns as the torque turns a positive spin.
        of_torque = np.copysign(1.0, top.torque)
        usual = np.where(runs.sense == 0, of_torque, runs.sense)
        direction = usual if runs.direction is None else runs.direction
        direction = np.where(direction == 0, usual, direction)
        # Equations (8) and (9) give the rate against the stars, which is the rate
        # against the floor plus that of the floor: stars = observed + direction *
        # floor. The fit needs the ratio stars/observed, with `observed` from the
        # readings, which do not depend on I_zz.
        observed = 2 * np.pi * runs.turns / runs.time
        stars_over_observed = 1 + direction * floor / observed
        return np.asarray(steady_rate / stars_over_observed)


HORIZONTAL = Horizontal()
STEADY = Steady()
RELEASED = Released()
PUSHED = Pushed()
EARTH = Earth()

MODELS: list[MotionModel] = [
    HORIZONTAL,
    STEADY,
    RELEASED,
    PUSHED,
    EARTH,
]
"""Every model of motion, in the order of the table of effects. The first one is the
equation of the fit without a correction. Of models with one name, or one effect, the
first stands for it."""


def ratio(steady: Floats, mean: Floats) -> Floats:
    """Divide the steady rate by the mean rate [1]; 1 without a torque."""
    return np.divide(steady, mean, out=np.ones_like(mean), where=mean != 0)


class Motion(Struct, frozen=True):
    """The models of a fit, in the order of `MODELS`, without the first one.

    Eq. (9), the first of `MODELS`, is in every fit, and is never listed.
    """

    models: tuple[MotionModel, ...] = ()
    """Empty for the steady precession of a level rod."""

    @property
    def named(self) -> MotionModel:
        """The last model that has a name: the one that the fit is called by."""
        named = [model for model in self.models if model.name]
        return named[-1] if named else HORIZONTAL

    @property
    def name(self) -> str:
        """Name of the fit's model in the JSON and in the option ``--model``."""
        return self.named.name

    @property
    def words(self) -> str:
        """The fit's model for users, after "by"."""
        return self.named.words

    @property
    def sags(self) -> bool:
        """Whether the rod starts from rest, and sags before it precesses."""
        return any(model.sags for model in self.models)

    @property
    def tilted(self) -> bool:
        """Whether the fit uses eq. (8) with each run's pitch, not eq. (9)."""
        return any(model.tilted for model in self.models)

    def of_effect(self, effect: str) -> MotionModel | None:
        """Return the model of an effect; None if the effect is left out."""
        of_effect = (model for model in self.models if model.effect == effect)
        return next(of_effect, None)

    def without(self, effect: str) -> Motion:
        """Return the same models without an effect."""
        others = [model for model in self.models if model.effect != effect]
        return Motion(tuple(others))

    def including(self, model: MotionModel) -> Motion:
        """Return these models and another one, in place of the one with its effect."""
        models = *self.without(model.effect).models, model
        return Motion(tuple(each for each in MODELS[1:] if each in models))

    def is_corrected(self, runs: TimedRuns) -> bool:
        """Return whether the runs need a correction by the result of the fit."""
        return any(model.is_corrected(runs) for model in self.models)

    def correction(
        self, top: Top, runs: TimedRuns
    ) -> tuple[Floats, tuple[ModelError, ...]]:
        """Return the product of the slowings of all models, and their errors.

        A slowing is the rate by the equation in the fit over the mean rate [1], shape
        (n,). The rate of a run without a torque is zero; its slowing is 1.
        """
        product = np.ones(len(runs.time))
        errors: list[ModelError] = []
        with np.errstate(divide="ignore", invalid="ignore"):
            steady = self._steady_rate(top, runs)
            for model in self.models:
                slowing = ratio(steady, model.mean_rate(top, runs, steady))
                product = product * slowing
                errors += model.errors(top, runs, slowing)
        return product, tuple(errors)

    def bias_if_left_out(self, top: Top, runs: TimedRuns) -> Floats:
        """Compute I_zz of each run by eq. (9) over I_zz with these models, minus 1.

        The shape is (n,). The fit does not use it: this is the size of an effect.
        """
        slowing, _ = self.correction(top, runs)
        with np.errstate(divide="ignore", invalid="ignore"):
            level = Motion()._steady_rate(top, runs)
            steady = self._steady_rate(top, runs)
            return ratio(level, steady) * slowing - 1

    def _steady_rate(self, top: Top, runs: TimedRuns) -> Floats:
        """Compute the rate by the equation in the fit [rad/s], shape (n,)."""
        lean = (top.transverse_inertia, runs.pitch) if self.tilted else (0.0, 0.0)
        rate = precession_rate(top.torque, runs.spin, top.inertia, *lean)
        return np.asarray(rate)


AUTO: Final = "auto"
"""The name by which a user asks for the simplest model that is good enough."""


def stated_or_asked(name: str, runs: TimedRuns) -> Motion:
    """Return the models that a log states, or one that a user asks for by name.

    The latter includes what the log states of the models before it in `MODELS`, which
    are simpler, and nothing of those behind it: a user who asks for "steady" gets no
    correction for a release, and a user who asks for any model gets none for the Earth.
    What is assumed of a silent log is added by `gyrodata.judging.changes.choose_model`.
    """
    stated = [model for model in MODELS if model.is_stated(runs)]
    if name == AUTO:
        return Motion(tuple(stated))
    asked = [model.name for model in MODELS].index(name)
    if asked == 0:
        return Motion()
    chosen = MODELS[asked]
    # A rod starts in one way: that of the model which the user asks for.
    simpler = [
        model
        for model in MODELS[1:asked]
        if model in stated and not (model.start and chosen.start)
    ]
    return Motion((*simpler, chosen))


def offered(stated: Motion, top: Top, runs: TimedRuns) -> Motion:
    """Add the possible models of a log that is silent about them to the stated ones."""
    motion = stated
    for model in MODELS:
        if model.is_silent(runs) and model.is_possible(top, runs):
            motion = motion.including(model)
    return motion


def names() -> tuple[str, ...]:
    """Return the names of all models, for the option ``--model``."""
    return tuple(dict.fromkeys(model.name for model in MODELS if model.name))


def of_effects() -> dict[str, MotionModel]:
    """Return the first model of each effect, in the order of the table."""
    models: dict[str, MotionModel] = {}
    for model in MODELS:
        if model.effect:
            models.setdefault(model.effect, model)
    return models


def source_words() -> dict[str, str]:
    """Return the names for users of all errors that models add."""
    words: dict[str, str] = {}
    for model in MODELS:
        words |= model.source_words
    return words
