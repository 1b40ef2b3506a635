"""Fit and judge the same log once, although many tests analyse or grade it.

These steps depend on nothing but their arguments, and nobody changes what they return.
It is found again by all that is in the arguments, so a log with another reading, line,
name or option is another one. A test that plants a fault in a step must not use this.
"""

from __future__ import annotations

import io
import pickle
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from gyrodata import analysis, fitting
from gyrodata.base.errors import LogError
from gyrodata.fitting import NoFit, inertia, screening
from gyrodata.results import FittedLog, Options

MOST_BYTES = 40_000
"""What belongs to a longer log is not kept."""

MOST_KEPT = 1000
"""So many results are kept: those that were asked for last."""

KEPT: OrderedDict[bytes, Any] = OrderedDict()
"""What a step returned or raised, by its name and all that is in its arguments."""


@contextmanager
def fitted_once() -> Iterator[None]:
    """Keep what the fit of a log, and what judges it, return for the same arguments."""
    with ExitStack() as stack:
        fit = _kept_by(inertia.fit, lambda *given: given)
        for module in (inertia, screening, fitting):
            stack.enter_context(patch.object(module, "fit", fit))
        for step, of in (
            (analysis.fit_log, _of_readings),
            (analysis.check_fit, _of_fit),
            (analysis.judge, _of_fit),
        ):
            kept = _kept_by(step, of)
            stack.enter_context(patch.object(analysis, step.__name__, kept))
        yield


def _of_readings(readings: Any, options: Options) -> object:
    return _fields(readings), _fields(options)


def _of_fit(fitted: FittedLog) -> object:
    """List what determines a fit: `fit_log` knows nothing else."""
    return _of_readings(fitted.readings, fitted.options)


def _fields(record: Any) -> list[Any]:
    return [getattr(record, name) for name in record.__struct_fields__]


def _kept_by(
    step: Callable[..., Any], arguments: Callable[..., object]
) -> Callable[..., Any]:
    """Return a step that is done once for the same arguments."""

    def once(*given: Any, **named: Any) -> Any:
        key = _text_of((step.__name__, arguments(*given), sorted(named.items())))
        if key is None or len(key) > MOST_BYTES:
            return step(*given, **named)
        if key not in KEPT:
            KEPT[key] = _outcome(step, *given, **named)
        KEPT.move_to_end(key)
        if len(KEPT) > MOST_KEPT:
            KEPT.popitem(last=False)
        outcome = KEPT[key]
        if isinstance(outcome, NoFit | LogError):
            raise outcome.with_traceback(None)
        return outcome

    return once


def _text_of(arguments: object) -> bytes | None:
    """Write arguments; equal ones as one text, even if they share other objects.

    Logs that are analysed together hold a function, and cannot be written.
    """
    text = io.BytesIO()
    pickler = pickle.Pickler(text)
    # Write an object again, not where it was before.
    pickler.fast = True
    try:
        pickler.dump(arguments)
    except (AttributeError, pickle.PicklingError):
        return None
    return text.getvalue()


def _outcome(step: Callable[..., Any], *given: Any, **named: Any) -> Any:
    try:
        return step(*given, **named)
    except (NoFit, LogError) as error:
        return error
