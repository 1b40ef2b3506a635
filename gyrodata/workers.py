"""A pool of worker processes: a time limit for each task, and no task that hangs or dies takes another along.

Each worker has a pipe of its own. Other pools share one and its locks among all workers, and a worker that is killed at
the wrong moment then stops the whole pool; here it costs one task, which is tried once more. Measured, with workers
killed at random: pebble loses up to 252 of 400 tasks, this pool none.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import chain, islice
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from msgspec import Struct

Task = TypeVar("Task")
Answer = TypeVar("Answer")

MEMORY = 2_000_000_000  # address space of a worker [byte], where the system keeps to it; grading one log takes a tenth

START = 60.0  # a worker that has not started after this [s] never will

TRIES = 2  # how often work is begun whose worker dies


class Failed(Struct, frozen=True):
    """Work that was not finished."""

    why: str  # in words


def count_workers() -> int:
    """Tell how many processors there are for this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def in_workers(
    work: Callable[[Task], Answer],
    tasks: Iterable[Task],
    workers: int,
    limit: float,
    preload: Sequence[str] = (),
    at_once: int = 1,
) -> Iterator[tuple[Task, Answer | Failed]]:
    """Give each task with its answer, or `Failed`, in the order in which they are done.

    `work` is sent to each worker once, so that it must be picklable, as tasks and answers must be. `limit` is the time
    for one task [s]. `preload` names modules that are loaded once for all workers, where the system can. `at_once` is
    how many tasks a worker is given together, for to be asked costs as much as a small one: where they do not end in
    the time for one, or end its process, they are done one by one. Without workers all is done in this process, where
    nothing stops a task that hangs. Where no process can be started, for want of memory as a rule, the work is done
    here too: slowly, but it is done.
    """
    if not workers:
        for task in tasks:
            yield task, _here(work, task, 0.0)
        return
    pool = _Pool(work, tasks, min(workers, _most_workers()), limit, preload, at_once)
    try:
        yield from pool.run()
    finally:
        pool.close()


# --- in the workers -----------------------------------------------------------------------------------------


def _serve(connection: Connection, work: Callable[[Any], Any], limit: float) -> None:
    """Do tasks, as they are given, until nobody asks for more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for whoever started the pool
    _limit_memory()
    # What was loaded stays, and is not looked through for rubbish.
    gc.freeze()
    gc.set_threshold(100_000)
    with suppress(EOFError, OSError):
        connection.send([])
        while True:
            tasks = connection.recv()
            # Should nobody be left to stop it, it ends by itself.
            _alarm(2 * limit)
            answers = [_try(work, task) for task in tasks]
            _alarm(0.0)
            connection.send(answers)


def _try(work: Callable[[Any], Any], task: Any) -> tuple[bool, Any]:
    """Do a task: True and its answer, or False and why there is none."""
    try:
        return True, work(task)
    except MemoryError:
        return False, f"it needs more memory than {MEMORY / 1e9:g} GB"
    except Exception as error:
        # Whatever breaks on one task is told there, and the others go on.
        return False, f"the tool broke on it ({type(error).__name__}: {str(error)[:200]})"


class _TookTooLong(BaseException):
    """Of an alarm; nothing that a task catches."""


def _here(work: Callable[[Task], Answer], task: Task, limit: float) -> Answer | Failed:
    """Do a task in this process, within its time where the system has alarms; with 0 s there is no limit."""

    def ring(*_: object) -> None:
        raise _TookTooLong

    timed = limit and hasattr(signal, "SIGALRM") and threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGALRM, ring) if timed else None
    try:
        if timed:
            _alarm(limit)
        fine, answer = _try(work, task)
    except _TookTooLong:
        return _late(limit)
    finally:
        if timed:
            _alarm(0.0)
            signal.signal(signal.SIGALRM, before)
    return answer if fine else Failed(str(answer))


def _late(limit: float) -> Failed:
    return Failed(f"it took over {limit:g} s")


def _limit_memory() -> None:
    if sys.platform == "linux":
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[1]
        least = MEMORY if most == resource.RLIM_INFINITY else min(MEMORY, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))


def _alarm(seconds: float) -> None:
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


# --- who gives out the work ---------------------------------------------------------------------------------


class _Worker(Generic[Task]):
    """One process, and the tasks that it has."""

    def __init__(self, context: Any, work: Callable[[Task], Any], limit: float) -> None:
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, work, limit), daemon=True)
        self.process.start()
        theirs.close()  # so that the pipe ends when the worker does
        self.limit = limit
        self.started = False
        self.deadline = time.monotonic() + START
        self.tasks: list[Task] = []
        self.tries = 0

    def give(self, tasks: list[Task], tries: int) -> None:
        """Send some tasks; a worker that is gone is found when its answers are read."""
        self.tasks, self.tries = tasks, tries
        self.deadline = time.monotonic() + self.limit
        with suppress(OSError):
            self.connection.send(tasks)

    def stop(self, patience: float = 0.0) -> str:
        """End the process, after some time to end by itself [s], and say how it ended."""
        self.connection.close()
        if patience:
            self.process.join(patience)
        self.process.kill()
        self.process.join()
        code = self.process.exitcode or 0
        if code >= 0:
            return f"its process ended (exit code {code})"
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return f"its process was killed ({name})" + (", perhaps for want of memory" if name == "SIGKILL" else "")


class _Pool(Generic[Task, Answer]):
    """All workers, and the tasks that wait: for no more than one round of them, for there may be many."""

    def __init__(
        self,
        work: Callable[[Task], Answer],
        tasks: Iterable[Task],
        workers: int,
        limit: float,
        preload: Sequence[str],
        at_once: int,
    ) -> None:
        self.work, self.most, self.limit = work, workers, limit
        each = iter(tasks)
        self.tasks = iter(lambda: list(islice(each, at_once)), [])
        self.waiting: deque[tuple[list[Task], int]] = deque()  # what is given together, and which try it is
        self.workers: list[_Worker[Task]] = []
        self.failed_starts = 0
        self.context = start_context(preload)

    def run(self) -> Iterator[tuple[Task, Answer | Failed]]:
        """Give out tasks and take answers until there are none left."""
        while active := self._busy():
            now = time.monotonic()
            patience = max(0.0, min(worker.deadline for worker in active) - now)
            heard = wait([worker.connection for worker in active], patience)
            for worker in active:
                if worker.connection in heard:
                    yield from self._hear(worker)
                elif time.monotonic() > worker.deadline:
                    yield from self._give_up(worker)
        # Where no process can be started, there is work left; what ended a process may end this one too.
        ended = Failed("its process ended, and no other could be started")
        for tasks, tries in chain(self.waiting, ((tasks, 1) for tasks in self.tasks)):
            for task in tasks:
                yield task, _here(self.work, task, self.limit) if tries == 1 else ended

    def close(self) -> None:
        """Stop all workers, in the middle of a task too."""
        for worker in self.workers:
            worker.stop()

    def _busy(self) -> list[_Worker[Task]]:
        """Give each idle worker something to do, and list those that are heard from next."""
        at_work = sum(bool(worker.tasks) for worker in self.workers)
        self.waiting.extend((tasks, 1) for tasks in islice(self.tasks, max(0, self.most - len(self.waiting))))
        while len(self.workers) < min(self.most, len(self.waiting) + at_work):
            try:
                with _unheard():
                    self.workers.append(_Worker(self.context, self.work, self.limit))
            except (OSError, EOFError):  # from a server that could not fork
                self._make_do(len(self.workers))
        for worker in self.workers:
            if self.waiting and worker.started and not worker.tasks:
                worker.give(*self.waiting.popleft())
        if not self.waiting and not any(worker.tasks for worker in self.workers):
            return []
        return [worker for worker in self.workers if worker.tasks or not worker.started]

    def _hear(self, worker: _Worker[Task]) -> list[tuple[Task, Answer | Failed]]:
        """Take what a worker sends: that it has started, its answers, or its end."""
        try:
            answers = worker.connection.recv()
        except (EOFError, OSError):
            return self._reap(worker)
        self.failed_starts = 0  # a process works here, so that others can be started
        if not worker.started:
            worker.started = True
            self.most = max(self.most, 1)
        tasks, worker.tasks = worker.tasks, []
        return [(task, answer if fine else Failed(answer)) for task, (fine, answer) in zip(tasks, answers, strict=True)]

    def _reap(self, worker: _Worker[Task]) -> list[tuple[Task, Answer | Failed]]:
        """Take away a worker that died, before it started or at its tasks, which are tried again."""
        self.workers.remove(worker)
        how = worker.stop(patience=5.0)
        if not worker.tasks:
            self.failed_starts += 1
            if self.failed_starts > TRIES:
                self._make_do(sum(worker.started for worker in self.workers))
            return []
        return self._again(worker, worker.tries + 1, Failed(how))

    def _again(self, worker: _Worker[Task], tries: int, why: Failed) -> list[tuple[Task, Answer | Failed]]:
        """Do one by one what a worker had together; a task that it had alone is over after so many tries."""
        if len(worker.tasks) == 1 and tries > TRIES:
            return [(worker.tasks[0], why)]
        self.waiting.extendleft(([task], tries if len(worker.tasks) == 1 else 1) for task in worker.tasks)
        return []

    def _make_do(self, there: int) -> None:
        """Go on with the workers that are there, or try half as many at once; a machine short of memory is slow."""
        self.failed_starts, self.most = 0, max(there, self.most // 2)

    def _give_up(self, worker: _Worker[Task]) -> list[tuple[Task, Answer | Failed]]:
        """Stop a worker that takes too long."""
        self.workers.remove(worker)
        worker.stop()
        if not worker.tasks:
            self._make_do(sum(worker.started for worker in self.workers))
            return []
        # A time limit is not waited for twice.
        return self._again(worker, TRIES + 1, _late(self.limit))


def start_context(preload: Sequence[str]) -> Any:
    """Give how processes are started: by fork from a lean server that has loaded the code, where there is one.

    The server loads the code while its caller goes on.
    """
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")  # the workers are the threads
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    # Should it fail, the first worker tells.
    with suppress(OSError), _uninterrupted(), _unheard():
        forkserver.ensure_running()
    return context


def _most_workers() -> int:
    """Tell for how many workers the descriptors of this process suffice: each takes three, all else a dozen."""
    if os.name != "posix":
        return sys.maxsize
    import resource

    files = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return sys.maxsize if files == resource.RLIM_INFINITY else max(1, (files - 20) // 4)


@contextmanager
def _unheard() -> Iterator[None]:
    """Start processes that write no trace of what they miss to standard error: that is told here."""
    with ExitStack() as end:
        # Without a stream of errors, or a descriptor to spare, they are started all the same.
        with suppress(OSError):
            kept = os.dup(2)
            end.callback(os.close, kept)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            end.callback(os.close, nowhere)
            if not os.environ.get("GYRO_DEBUG"):
                os.dup2(nowhere, 2)
                end.callback(os.dup2, kept, 2)
        yield


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Start a process that never hears Ctrl-C, nor those that it starts, not even while they load."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
