"""Worker processes that take tasks one by one and are ended from outside when one takes too long.

Results come in the order of the tasks. A worker that crashes costs its task and is replaced.
"""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

_PR_SET_PDEATHSIG = 1
_MOST_WAITING = 4096  # results that wait for an earlier one
_MOST_WAITING_BYTES = 64 << 20

Work = Callable[[Any], tuple[bytes, dict[str, Any]]]


@dataclass
class Outcome:
    """What became of a task.

    Attributes:
        data: what the output gets; empty where the task failed.
        facts: plain values about it; "error" is why it failed.
    """

    data: bytes
    facts: dict[str, Any]


class _Worker:
    """A process, the pipe to it, and the task that it has."""

    def __init__(self, work: Work, prepare: Callable[[], None]):
        context = multiprocessing.get_context("fork")
        self.pipe, end = context.Pipe()
        self.process = context.Process(
            target=_serve, args=(work, prepare, end, os.getpid()), daemon=True
        )
        sys.stdout.flush()
        sys.stderr.flush()
        self.process.start()
        end.close()
        self.number: int | None = None
        self.since = 0.0

    def give(self, number: int, task: Any) -> None:
        """Hand a task over."""
        self.number, self.since = number, time.monotonic()
        self.pipe.send(task)

    def end(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _serve(work: Work, prepare: Callable[[], None], pipe: Connection, parent: int) -> None:
    """What a worker does: take a task, send its result, until there is nothing at the other end."""
    _die_with(parent)
    # an interruption is for the parent to handle
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)
    _let_go_of_files(pipe.fileno())
    prepare()
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            os._exit(0)
        try:
            data, facts = work(task)
        except MemoryError:
            data, facts = b"", {"error": "there is not enough memory for it"}
        except Exception as error:  # a defect of ours, which must not end the run
            data, facts = b"", {"error": f"{type(error).__name__}: {error}"}
        try:
            pipe.send((data, facts))
        except OSError:
            os._exit(0)


def _die_with(parent: int) -> None:
    """Let the kernel end this process when its parent ends, however that happens."""
    try:
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    except (AttributeError, OSError):  # not Linux; the pipe's end has to do
        return
    if os.getppid() != parent:
        os._exit(0)


def _let_go_of_files(kept: int) -> None:
    """Put nothing in the place of all open files but one: pipes of others, locks, the terminal."""
    nothing = os.open(os.devnull, os.O_RDWR)
    try:
        numbers = [int(name) for name in os.listdir("/proc/self/fd")]
    except OSError:
        numbers = list(range(256))
    for number in numbers:
        if number not in (kept, nothing):
            with contextlib.suppress(OSError):  # it was open for the listing alone
                os.fstat(number)
                os.dup2(nothing, number, inheritable=number <= 2)


class Pool:
    """Worker processes; a context manager that ends them all."""

    def __init__(
        self,
        work: Work,
        count: int,
        seconds: float,
        prepare: Callable[[], None] = lambda: None,
    ):
        """Start the workers.

        Args:
            work: what is done with a task; it runs in the workers.
            count: workers.
            seconds: after which a task is given up and its worker replaced.
            prepare: called in each worker before its first task.
        """
        self._work = work
        self._prepare = prepare
        self._seconds = seconds
        self._workers: list[_Worker] = []
        for _ in range(count):
            self._workers.append(_Worker(work, prepare))

    def outcomes(self, tasks: Iterator[Any]) -> Iterator[tuple[Any, Outcome]]:
        """Each task with its outcome, in the order of the tasks, which are taken as needed."""
        given: dict[int, Any] = {}  # handed out or waiting for an earlier one
        done: dict[int, Outcome] = {}
        size, first, next_, is_over = 0, 0, 0, False
        while True:
            for worker in self._workers:
                room = len(done) < _MOST_WAITING and size < _MOST_WAITING_BYTES
                if worker.number is not None or is_over or not (room or next_ == first):
                    continue
                try:
                    task = next(tasks)
                except StopIteration:
                    is_over = True
                    break
                given[next_] = task
                self._give(worker, next_, task)
                next_ += 1
            if not given:
                return
            for number, outcome in self._collected():
                done[number] = outcome
                size += len(outcome.data)
            while first in done:
                outcome = done.pop(first)
                size -= len(outcome.data)
                first += 1
                yield given.pop(first - 1), outcome

    def _give(self, worker: _Worker, number: int, task: Any) -> None:
        try:
            worker.give(number, task)
        except OSError:  # it died while it was idle
            self._replace(worker)
            self._workers[-1].give(number, task)

    def _collected(self) -> list[tuple[int, Outcome]]:
        """What has been done, or given up, since the last time; waits for something."""
        busy = [worker for worker in self._workers if worker.number is not None]
        now = time.monotonic()
        left = min((worker.since + self._seconds - now for worker in busy), default=0.0)
        ready = set(wait([worker.pipe for worker in busy], max(left, 0.0)))
        found = []
        for worker in busy:
            number = worker.number
            if worker.pipe in ready:
                try:
                    data, facts = worker.pipe.recv()
                    worker.number = None
                except (EOFError, OSError):
                    facts = {"error": self._death(worker)}
                    data = b""
                    self._replace(worker)
            elif time.monotonic() - worker.since >= self._seconds:
                data = b""
                facts = {"error": f"it took longer than {self._seconds:g} s"}
                self._replace(worker)
            else:
                continue
            found.append((number, Outcome(data, facts)))
        return found

    @staticmethod
    def _death(worker: _Worker) -> str:
        worker.process.join(5)
        code = worker.process.exitcode
        if code is not None and code < 0:
            return f"the process that worked on it died of {signal.Signals(-code).name}"
        return f"the process that worked on it ended with code {code}"

    def _replace(self, worker: _Worker) -> None:
        worker.end()
        self._workers.remove(worker)
        self._workers.append(_Worker(self._work, self._prepare))

    def close(self) -> None:
        """End all workers."""
        while self._workers:
            self._workers.pop().end()

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()
