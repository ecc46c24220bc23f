"""Who does the work: this process, several of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from importlib import import_module
from itertools import chain, islice
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from types import ModuleType
from typing import Any, TypeVar

from gspcli.errors import GspError
from gspcli.records import dataclass
from gspcli.wording import shown

Item = TypeVar("Item")
Result = TypeVar("Result")

#: How long to wait for a Dask scheduler to answer, and for its first worker.
_CONNECTING_S = 10
#: Items handed over for each worker: one that it does and one that it takes next.
_AHEAD = 2


@dataclass(frozen=True)
class Workers:
    """Processes that do pieces of work; the results do not depend on them.

    Attributes
    ----------
    jobs
        How many processes; with one the work is done in this process.
    scheduler
        Address of a Dask scheduler whose workers do it instead. What a lost worker was doing
        is done by another one.

    Raises
    ------
    GspError
        By the methods: if there is no such scheduler, it has no workers, or one has several
        threads; if processes die.
    """

    jobs: int = 1
    scheduler: str | None = None

    def as_completed(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Result]:
        """Yield ``function(item)`` for each item, as they become known.

        Parameters
        ----------
        function
            Must be picklable, and its results, unless the work is done in this process.
        items
            Taken a little ahead of the results.
        """
        with closing(self._numbered(function, items)) as results:
            for _, result in results:
                yield result

    def in_order(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Result]:
        """Yield the same in the order of the items."""
        early: dict[int, Result] = {}
        wanted = 0
        with closing(self._numbered(function, items)) as results:
            for number, result in results:
                early[number] = result
                while wanted in early:
                    yield early.pop(wanted)
                    wanted += 1

    def _numbered(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Generator[tuple[int, Result]]:
        waiting = enumerate(items)
        first = list(islice(waiting, 2))
        numbered = chain(first, waiting)
        if self.scheduler is not None:
            with _client(self.scheduler) as client:
                executor = client.get_executor(pure=False)
                yield from _fed(
                    executor, function, numbered, lambda: len(client.nthreads()), cancel=True
                )
        elif self.jobs == 1 or len(first) < 2:
            for number, item in numbered:
                yield number, function(item)
        else:
            with _processes(self.jobs) as executor:
                yield from _fed(executor, function, numbered, lambda: self.jobs)


#: This process.
HERE = Workers()


def _fed(
    executor: Executor,
    function: Callable[[Item], Result],
    numbered: Iterator[tuple[int, Item]],
    workers: Callable[[], int],
    *,
    cancel: bool = False,
) -> Iterator[tuple[int, Result]]:
    """Keep an executor busy; yield the numbers of the items with their results.

    What runs when it is left can be cancelled. Of processes that are ended it must not be: the
    thread that looks after them would complain that it cannot say so of a cancelled future.
    """
    running: dict[Future[Result], int] = {}
    try:
        while True:
            free = max(0, _AHEAD * workers() - len(running))
            for number, item in islice(numbered, free):
                running[executor.submit(function, item)] = number
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
    finally:
        for future in running if cancel else ():
            future.cancel()


#: If a signal ends this process, another one of the standard library removes its semaphores. The
#: warning that it prints then is none for a user.
_OF_TRACKER = "ignore::UserWarning:multiprocessing.resource_tracker"


@contextmanager
def _processes(jobs: int) -> Iterator[Executor]:
    """Start processes, which end at once when the context ends, also during work."""
    others = set(active_children())
    # Not forked: threads of the tracker may be running.
    if _OF_TRACKER not in sys.warnoptions:
        sys.warnoptions.append(_OF_TRACKER)
    executor = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_follow_parent)
    try:
        yield executor
    except BrokenProcessPool as error:
        message = "a process was killed, perhaps because memory was exhausted: use fewer --jobs"
        raise GspError(message) from error
    finally:
        executor.shutdown(wait=False)
        for process in set(active_children()) - others:
            _end(process)


def _follow_parent() -> None:
    """Lead a group of processes, out of reach of Ctrl-C, that ends with the parent process."""
    if os.name == "posix":
        os.setpgrp()
        Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os.killpg(0, signal.SIGTERM)


def _end(process: BaseProcess) -> None:
    """End a process and the programs that it has started."""
    try:
        assert process.pid is not None
        os.killpg(process.pid, signal.SIGTERM)
    except (AttributeError, ProcessLookupError):
        # There are no groups on this system, or it has not founded its own yet.
        process.terminate()


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """Connect to a Dask scheduler."""
    try:
        distributed = import_module("distributed")
    except ModuleNotFoundError as error:
        message = "--scheduler needs Dask: pip install 'gspcli[cluster]'"
        raise GspError(message) from error
    # It says at length on standard error what is said here in a line.
    with _silenced("distributed.client"), _connected(distributed, address) as client:
        yield client


@contextmanager
def _silenced(name: str) -> Iterator[None]:
    """Let a library say nothing that is not critical."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)


@contextmanager
def _connected(distributed: ModuleType, address: str) -> Iterator[Any]:
    try:
        client = distributed.Client(address, timeout=_CONNECTING_S)
    except (OSError, TimeoutError, ValueError) as error:
        message = f"no Dask scheduler at {shown(address)}: start one by `dask scheduler`"
        raise GspError(message) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_CONNECTING_S)
        except TimeoutError as error:
            message = (
                f"{address} has no workers: start some by `dask worker {address} --nthreads 1`"
            )
            raise GspError(message) from error
        # The precision of ball arithmetic is a setting of the whole process.
        if any(threads > 1 for threads in client.nthreads().values()):
            message = f"a worker of {address} has several threads: start it with --nthreads 1"
            raise GspError(message)
        try:
            yield client
        except distributed.KilledWorker as error:
            message = f"{address} lost too many workers: {error}"
            raise GspError(message) from error
        except (CancelledError, OSError, TimeoutError) as error:
            message = f"the connection to the Dask scheduler at {address} was lost"
            raise GspError(message) from error
