"""Tasks side by side in one thread, whose sums are done together.

Of arrays as small as a log's the calls of numpy cost more than the numbers. So each task runs as if it were alone, in a
coroutine of its own; where it calls a function that is `stacked`, it waits until all others have come to such a call,
or to their end, and calls that are alike are answered as one. No answer depends on what is beside it in the stack.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from contextvars import ContextVar
from functools import wraps
from typing import Any, ParamSpec, TypeVar, cast

Task = TypeVar("Task")
Answer = TypeVar("Answer")
Given = ParamSpec("Given")

_HUB: ContextVar[Any] = ContextVar("hub", default=None)  # where a task beside others waits for what it asks


def stacked(
    alike: Callable[..., Hashable],
) -> Callable[[Callable[[Sequence[Any]], list[Answer]]], Callable[..., Answer]]:
    """Make a function that answers a list of calls, each a tuple of arguments, one that is called with arguments.

    Calls for which `alike` gives the same are answered together, and none by what the others are; one for which it
    gives None is answered alone. An answer may be an exception: it is raised where it was asked for.
    """

    def decorate(kernel: Callable[[Sequence[Any]], list[Answer]]) -> Callable[..., Answer]:
        @wraps(kernel)
        def ask(*arguments: Any) -> Answer:
            hub = _HUB.get()
            answer: Any
            if hub is None or (kind := alike(*arguments)) is None:
                answer = _answers(kernel, [arguments])[0]
            else:
                answer = hub.switch((kernel, kind), arguments)
            if isinstance(answer, Exception):
                raise answer
            return cast(Answer, answer)

        return ask

    return decorate


def _answers(kernel: Callable[[Sequence[Any]], list[Any]], calls: Sequence[Any]) -> list[Any]:
    """Answer calls together; where that breaks, one by one, so that it breaks for those only that it is about."""
    try:
        return kernel(calls)
    except Exception as error:
        return [error] if len(calls) == 1 else [_answers(kernel, [call])[0] for call in calls]


@stacked(lambda function: function)
def _meet(calls: Sequence[Any]) -> list[None]:
    return [None] * len(calls)


def in_step(function: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """Begin a function where all others beside it begin it too: what is run many times in a row is in the cache."""

    @wraps(function)
    def begin(*arguments: Given.args, **named: Given.kwargs) -> Answer:
        _meet(function)
        return function(*arguments, **named)

    return begin


def side_by_side(work: Callable[[Task], Answer], tasks: Sequence[Task]) -> list[Answer]:
    """Do tasks, the calls of stacked functions in them together."""
    if len(tasks) < 2:
        return [work(task) for task in tasks]
    # Who analyses one log does not need it.
    from greenlet import getcurrent, greenlet

    hub = getcurrent()
    answers: dict[int, Answer] = {}

    def alone(at: int) -> None:
        _HUB.set(hub)
        answers[at] = work(tasks[at])

    asking: dict[Any, list[tuple[Any, Any]]] = {}

    def go_on(one: Any, told: object) -> None:
        asked = one.switch(told)
        if not one.dead:
            asking.setdefault(asked[0], []).append((one, asked[1]))

    for at, one in enumerate([greenlet(alone) for _ in tasks]):
        go_on(one, at)
    while asking:
        # Those who are behind go first, so that they ask together with the others again.
        kind = min(asking, key=lambda kind: len(asking[kind]))
        calls = asking.pop(kind)
        for (one, _), answer in zip(calls, _answers(kind[0], [call for _, call in calls]), strict=True):
            go_on(one, answer)
    return [answers[at] for at in range(len(tasks))]
