"""Runs a campaign: distributes its tasks, and continues after dead workers and interrupts."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

from arctrue.studies.campaign.code_state import WHOLE_PACKAGE, Sources, commit
from arctrue.studies.campaign.dask_cluster import cluster
from arctrue.studies.campaign.store import COMMIT, Store
from arctrue.studies.campaign.task import (
    CampaignError,
    OtherCodeError,
    Task,
    digest,
    do_batch,
    task_key,
)

Batch = Sequence[Task]
Results = list[tuple[Mapping[str, Any], float]]
Done = tuple[Batch, Results]
DoBatch = Callable[[Batch], Results]
MOST_BROKEN_POOLS = 3
"""Number of consecutive broken pools without a result after which the campaign ends. A task that
kills its worker is then the likely cause."""


STOP_POLL_S = 0.5
PARENT_POLL_S = 2.0
STOPS = (signal.SIGINT, signal.SIGTERM)
"""Signals that stop a campaign: Ctrl-C sends the first, a batch system sends the second at a job's
time limit."""


class Interrupted(Exception):  # noqa: N818 - no error: the user wished it
    """Raised when a signal stops the campaign; finished results are on the disk."""

    def __init__(self, done: int, total: int) -> None:
        """Make a message with the number of finished tasks and the number of all tasks."""
        super().__init__(f"{done} of {total} are done; the same command continues from there")


@dataclass(frozen=True, slots=True)
class Speed:
    """Progress of a campaign.

    Parameters
    ----------
    done : int
        Number of finished tasks.
    total : int
        Number of all tasks.
    tasks_per_s : float
        Number of tasks that this run finishes per second.
    """

    done: int
    total: int
    tasks_per_s: float

    @property
    def seconds_left(self) -> float:
        """Estimate the remaining time in seconds from the rate; infinite before the first task is
        done."""
        left = self.total - self.done
        if not left:
            return 0.0
        return left / self.tasks_per_s if self.tasks_per_s else float("inf")


ReportSpeed = Callable[[Speed], None]
"""Function that receives the progress of a campaign after each batch."""


@dataclass(frozen=True)
class Campaign:
    """Tasks of one kind and the folder of their results.

    Parameters
    ----------
    work : str
        Function as ``module:function``, importable on every worker.
    tasks : sequence of mapping
        Arguments of the function, one per task.
    folder : Path
        Folder of the results.
    facts : mapping
        Further facts in the header; a run with other facts may not use the same folder.
    batch : int, optional
        Number of tasks that a worker takes at once; a larger number suits short tasks.
    sources : Sources, optional
        The sources on which the results depend.
    """

    work: str
    tasks: Sequence[Task]
    folder: Path
    facts: Mapping[str, Any]
    batch: int = 1
    sources: Sources = WHOLE_PACKAGE

    def header(self) -> dict[str, Any]:
        """Return the facts that identify the campaign.

        Returns
        -------
        dict
            Work, tasks, state and commit of the code, and the facts.
        """
        return {
            "work": self.work,
            "tasks": len(self.tasks),
            "tasks_digest": digest([task_key(task) for task in self.tasks]),
            "code": self.sources.state(),
            COMMIT: commit(),
            **self.facts,
        }

    def run(
        self,
        *,
        workers: int | None = None,
        scheduler: str | None = None,
        shard: tuple[int, int] | None = None,
        report_speed: ReportSpeed | None = None,
    ) -> int:
        """Do all tasks that have no result yet.

        Parameters
        ----------
        workers : int, optional
            Number of processes in the pool; default: one for each core.
        scheduler : str, optional
            Address of a Dask scheduler that is used in place of a pool.
        shard : (int, int), optional
            (i, n): every n-th task from the i-th on, 1 ≤ i ≤ n.
        report_speed : callable, optional
            Function that is called with a :class:`Speed` at the start and after each batch.

        Returns
        -------
        int
            Number of finished tasks of this shard.

        Raises
        ------
        ValueError
            There is no such shard.
        Interrupted
            A signal (Ctrl-C, or the time limit of a batch system) stopped the campaign.
        CampaignError
            Workers die repeatedly, or their code differs from that of the campaign.
        StoreError
            The folder belongs to another campaign or another state of the code, or has two results
            for one task.
        """
        mine = list(self.tasks)
        name = ""
        if shard is not None:
            place, number = shard
            if not 1 <= place <= number:
                raise ValueError(f"a shard is 1/n … n/n, found {place}/{number}")
            mine = mine[place - 1 :: number]
            name = f"-{place}-of-{number}"
        header = self.header()
        with Store(self.folder, header, name) as store:
            left = [task for task in mine if task_key(task) not in store.done]
            batches = [left[at : at + self.batch] for at in range(0, len(left), self.batch)]
            done_before, begin = len(mine) - len(left), time.monotonic()
            done = done_before
            if report_speed is not None:
                report_speed(Speed(done, len(mine), 0.0))
            do = partial(do_batch, self.work, sources=self.sources, code=header["code"])
            with _interrupts() as stopping:
                if scheduler is None:
                    finished = pool(do, batches, workers or os.cpu_count() or 1, stopping)
                else:
                    finished = cluster(do, batches, scheduler, stopping)
                for tasks, results in _of_one_state(finished):
                    for task, (result, seconds) in zip(tasks, results, strict=True):
                        store.add(task, result, seconds)
                        done += 1
                    if report_speed is not None:
                        rate = (done - done_before) / max(time.monotonic() - begin, 1e-9)
                        report_speed(Speed(done, len(mine), rate))
                if stopping():
                    raise Interrupted(done, len(mine))
            return done


def _of_one_state(finished: Iterator[Done]) -> Iterator[Done]:
    try:
        yield from finished
    except OtherCodeError as error:
        raise CampaignError(f"{error}; results so far are kept") from error


def pool(
    do: DoBatch, batches: Sequence[Batch], workers: int, stopping: Callable[[], bool]
) -> Iterator[Done]:
    """Yield batches as processes of this machine finish them.

    A killed worker breaks the pool: a new pool repeats all unfinished batches. Once ``stopping()``
    is true, no new batch starts; batches that already run are still finished and yielded. Raises
    CampaignError if pools break repeatedly without a result in between.
    """
    # numpy in the workers reads this variable; with one thread, sums do not depend on the number of
    # cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    left = dict(enumerate(batches))
    broken = 0
    while left and not stopping():
        executor = ProcessPoolExecutor(
            max_workers=min(workers, len(left)),
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_serve_the_parent,
            initargs=(os.getpid(),),
        )
        waiting = iter(list(left))
        running: dict[Future[Results], int] = {}
        try:
            while True:
                # Only a few batches are submitted in advance, because a stop must wait until all
                # submitted batches end.
                while not stopping() and len(running) < workers + 1:
                    number = next(waiting, None)
                    if number is None:
                        break
                    running[executor.submit(do, left[number])] = number
                if not running:
                    break
                finished, _ = wait(running, STOP_POLL_S, FIRST_COMPLETED)
                for future in finished:
                    number = running.pop(future)
                    results = future.result()
                    broken = 0
                    yield left.pop(number), results
        except BrokenProcessPool as error:
            broken += 1
            if broken >= MOST_BROKEN_POOLS:
                raise CampaignError(
                    f"workers were killed {broken} times without a result in between; "
                    "is there too little memory? Finished results are kept"
                ) from error
        finally:
            executor.shutdown(cancel_futures=True)


@contextmanager
def _interrupts() -> Iterator[Callable[[], bool]]:
    """Yield a function that tells whether a stop signal has arrived; a second signal ends the
    program at once."""
    pressed = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield pressed.is_set
        return

    def note(number: int, frame: FrameType | None) -> None:
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    before = {number: signal.signal(number, note) for number in STOPS}
    try:
        yield pressed.is_set
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _serve_the_parent(parent: int) -> None:
    """Ignore interrupts, which the parent handles, and end the worker when the parent has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_POLL_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
