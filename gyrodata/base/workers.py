"""Work in several processes.

A task that hangs, or ends its process, costs only that task.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    as_completed,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from multiprocessing.connection import wait
from typing import Any, TypeVar

from msgspec import Struct

Task = TypeVar("Task")
Answer = TypeVar("Answer")

# address space of a worker [byte]; to grade one log takes a tenth of it
MEMORY = 2_000_000_000


_file: ContextVar[str] = ContextVar("_file", default="")


def reads_file(name: str) -> None:
    """Note the file that a task reads, so that a failure can name it; "" for none."""
    _file.set(name)


class Failed(Struct, frozen=True):
    """A task that was not finished."""

    why: str  # in words
    file: str = ""  # name of the file that was read, if the task said so

    def __str__(self) -> str:
        return f"the file {self.file}: {self.why}" if self.file else self.why


class _TookTooLong(BaseException):
    """Raised by an alarm; no task catches it."""


def count_workers() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def in_workers(
    work: Callable[[Task], Answer],
    tasks: Sequence[Task],
    workers: int,
    limit: float,
    cluster: Executor | None = None,
) -> Generator[tuple[Task, Answer | Failed], None, None]:
    """Give each task with its answer, or `Failed`, in the order in which they are done.

    Parameters
    ----------
    work : callable
        A function of a module, or a `functools.partial` of one: it is sent to the
        workers with each task.
    tasks : sequence
        The arguments of `work`, one at a time.
    workers : int
        Number of processes. With 0 everything is done in this process, and nothing
        stops a task that hangs.
    limit : float
        Time for one task [s].
    cluster : Executor, optional
        Does the work instead, on other machines; it is left open.
    """
    if not workers and cluster is None:
        for task in tasks:
            yield task, _do(work, task, 0.0)
        return
    lost = yield from _in_one_pool(work, tasks, workers, limit, cluster)
    # A process that dies ends the whole pool. The task that killed it is found by
    # halves: the others are done again, and a task that ends its process when it is the
    # only one is not.
    if len(lost) == len(tasks) == 1:
        why = "its process ended without an answer, perhaps for want of memory"
        yield lost[0], Failed(why)
        return
    middle = len(lost) // 2
    for half in filter(None, (lost[:middle], lost[middle:])):
        # Never in this process, which the task could end too.
        yield from in_workers(work, half, max(workers, 1), limit)


def _in_one_pool(
    work: Callable[[Task], Answer],
    tasks: Sequence[Task],
    workers: int,
    limit: float,
    cluster: Executor | None,
) -> Generator[tuple[Task, Answer | Failed], None, list[Task]]:
    """Give each task with its answer, and return those that were lost with the pool."""
    lost: list[Task] = []
    processes = min(workers, len(tasks)) or 1
    with _pool(processes) if cluster is None else nullcontext(cluster) as pool:
        futures = {}
        for batch in _batches(tasks, 0 if cluster else workers):
            try:
                futures[pool.submit(_do_all, work, batch, limit)] = batch
            except BrokenProcessPool:
                lost += batch
        for future in as_completed(futures):
            batch = futures[future]
            answers = _answers(future, len(batch))
            if answers is None:
                lost += batch
            else:
                yield from zip(batch, answers, strict=True)
    return lost


def _batches(tasks: Sequence[Task], workers: int) -> Iterator[Sequence[Task]]:
    """Yield tasks that are sent together to one of some workers; 0 for a cluster.

    To send them one by one costs a twentieth of grading. Without an alarm, or on a
    cluster, one can spoil others.
    """
    size = 1
    if workers and hasattr(signal, "setitimer"):
        size = min(8, len(tasks) // (8 * workers) + 1)
    for start in range(0, len(tasks), size):
        yield tasks[start : start + size]


def _answers(
    future: Future[list[Answer | Failed]], count: int
) -> list[Answer | Failed] | None:
    """Return the answers to some tasks; None if their process ended."""
    try:
        return future.result()
    except BrokenProcessPool:
        return None
    except (Exception, CancelledError) as error:
        # A cluster has lost its worker or its scheduler.
        why = f"its worker was lost ({type(error).__name__})"
        return [Failed(why)] * count


@contextmanager
def _pool(workers: int) -> Iterator[Executor]:
    """Start processes that ignore Ctrl-C, and end them all, even during a task."""
    others = multiprocessing.active_children()
    # A forked process has loaded all code already. Only on Linux is it safe to fork.
    method = "fork" if sys.platform == "linux" else None
    context = multiprocessing.get_context(method)
    pool = ProcessPoolExecutor(workers, context, _begin)
    try:
        yield pool
    except BaseException:
        for process in set(multiprocessing.active_children()).difference(others):
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """Let a worker ignore Ctrl-C, limit its memory, and end it with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if sys.platform == "linux":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
            pages = int(file.read().split()[0])
        limit = pages * resource.getpagesize() + MEMORY
        if most != resource.RLIM_INFINITY:
            limit = min(limit, most)
        resource.setrlimit(resource.RLIMIT_AS, (limit, most))


def _end_with_parent() -> None:
    parent: Any = multiprocessing.parent_process()
    wait([parent.sentinel])
    os._exit(1)


def _do_all(
    work: Callable[[Task], Answer], tasks: Sequence[Task], limit: float
) -> list[Answer | Failed]:
    """Do some tasks, one after the other; `limit`: time for each [s]."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere:  # noqa: PTH123
        # Ends the process if the alarm does not help.
        last_moment = (len(tasks) + 1) * limit
        faulthandler.dump_traceback_later(last_moment, exit=True, file=nowhere)
        try:
            return [_do(work, task, limit) for task in tasks]
        finally:
            faulthandler.cancel_dump_traceback_later()


def _do(work: Callable[[Task], Answer], task: Task, limit: float) -> Answer | Failed:
    """Do one task, and return its result or its error; a limit [s] of 0 is none."""

    def ring(*_: object) -> None:
        raise _TookTooLong

    reads_file("")
    # A worker of a cluster has threads, which no signal reaches.
    in_main_thread = threading.current_thread() is threading.main_thread()
    alarm = limit and in_main_thread and hasattr(signal, "setitimer")
    try:
        if alarm:
            signal.signal(signal.SIGALRM, ring)
            signal.setitimer(signal.ITIMER_REAL, limit)
        return work(task)
    except _TookTooLong:
        why = f"it took over {limit:g} s"
    except MemoryError:
        why = f"it needs more memory than {MEMORY / 1e9:g} GB"
    except Exception as error:
        kind = type(error).__name__
        why = f"the tool broke on it ({kind}: {str(error)[:200]})"
    finally:
        if alarm:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    return Failed(why, _file.get())
