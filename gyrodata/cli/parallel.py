"""Many logs at once: the same work in worker processes, its answers in the order of the logs."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")

WORTHWHILE = 50
"""So many logs take longer than it does to start the workers."""

_BATCH = 8
"""Items that a worker takes at a time."""


def in_order(work: Callable[[Item], Answer], items: Sequence[Item]) -> Iterator[Answer]:
    """Give the answers one by one, worked out by as many processes as there are processors to use.

    A few items are done here, in this process. `work` and its items have to be picklable; what it prints is lost.
    No more than a few answers wait for their turn, so that the memory does not grow with their number.
    """
    workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers < 2 or len(items) < WORTHWHILE:
        yield from map(work, items)
        return
    from concurrent.futures import Future, ProcessPoolExecutor

    # What the first one loads, the workers then have.
    yield work(items[0])
    batches = [items[i : i + _BATCH] for i in range(1, len(items), _BATCH)]
    with ProcessPoolExecutor(workers, initializer=_leave_interrupts_to_the_parent) as pool:
        waiting: deque[Future[list[Answer]]] = deque()
        try:
            for batch in batches:
                waiting.append(pool.submit(_batch, work, batch))
                if len(waiting) > 4 * workers:
                    yield from waiting.popleft().result()
            while waiting:
                yield from waiting.popleft().result()
        finally:
            # A reader that has gone away, or Ctrl-C: what has not begun never does.
            pool.shutdown(cancel_futures=True)


def _batch(work: Callable[[Item], Answer], items: Sequence[Item]) -> list[Answer]:
    return [work(item) for item in items]


def _leave_interrupts_to_the_parent() -> None:
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
