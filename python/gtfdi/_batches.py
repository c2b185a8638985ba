"""The runs of a campaign on the workers of an executor."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from math import ceil
from time import perf_counter
from typing import Any, Protocol

from gtfdi._gtfdi import _CampaignDesk, _CampaignTask
from gtfdi.errors import GtfdiError, OptionError

#: Seconds that a batch is to take: long beside what handing it over costs, short beside what is
#: lost when it is interrupted.
BATCH_S = 4.0

#: Batches handed out at a time to an executor that does not say how many workers it has.
UNKNOWN_IN_FLIGHT = 64

#: Seconds between two looks for Ctrl-C, where waiting does not end by it.
LOOK_EVERY_S = 1.0

#: Seconds that a batch took, and its parts.
Outcome = tuple[float, list[tuple[int, str, bytes]]]


class Client(Protocol):
    """A client of dask.distributed, which need not be there."""

    def get_executor(self, **options: Any) -> Executor:
        """An executor whose workers are those of the client's cluster."""


def work(task: _CampaignTask, chunks: list[int]) -> Outcome:
    """What a worker does: the rows of some chunks, and how long it took."""
    start = perf_counter()
    parts = task.parts(chunks)
    return perf_counter() - start, parts


def executor_of(executor: Executor | Client) -> Executor:
    """An executor as it is, or that of a dask client."""
    if isinstance(executor, Executor):
        return executor
    if callable(getattr(executor, "get_executor", None)):
        # Not pure: what failed once is to be tried again when it is asked for again.
        return executor.get_executor(pure=False)
    raise OptionError(
        "option executor: expected an executor of concurrent.futures or a client of "
        f"dask.distributed, found {type(executor).__name__}"
    )


def limit_of(executor: Executor, in_flight: int | None) -> int:
    """How many batches are handed out at a time."""
    if in_flight is None:
        workers = getattr(executor, "_max_workers", None)
        return 2 * workers if isinstance(workers, int) else UNKNOWN_IN_FLIGHT
    if in_flight < 1:
        raise OptionError(f"option in_flight: expected 1 or more, found {in_flight}")
    return in_flight


class Batches:
    """Chunks of a campaign on their way to workers and back."""

    def __init__(self, desk: _CampaignDesk, executor: Executor, limit: int, out: str) -> None:
        self.desk = desk
        self.executor = executor
        self.limit = limit
        self.out = out
        self.waiting = deque(desk.missing())
        self.running: dict[Future[Outcome], list[int]] = {}
        self.spent_s = 0.0
        self.done = 0

    def run(self) -> None:
        """Hands out all that is missing and keeps what comes back."""
        task = self.desk.task()
        try:
            while self.waiting or self.running:
                while self.waiting and len(self.running) < self.limit:
                    self._hand_out(task)
                done, _ = wait(self.running, LOOK_EVERY_S, FIRST_COMPLETED)
                failed = [failure for future in done for failure in self._take_back(future)]
                for chunks, error in failed[:1]:
                    self._fail(chunks, error)
        finally:
            for future in self.running:
                future.cancel()

    def _size(self) -> int:
        """Chunks of the next batch: few at first and at the end, so that all workers have some."""
        share = ceil(len(self.waiting) / self.limit)
        each_s = self.spent_s / self.done if self.done else BATCH_S
        return max(1, min(share, int(BATCH_S / max(each_s, 1e-9))))

    def _hand_out(self, task: _CampaignTask) -> None:
        chunks = [self.waiting.popleft() for _ in range(self._size())]
        try:
            future = self.executor.submit(work, task, chunks)
        except Exception as error:
            # What is under way is lost with the executor, but for what has just come back.
            for future in [future for future in self.running if future.done()]:
                self._take_back(future)
            self._fail(chunks, error)
        self.running[future] = chunks

    def _take_back(self, future: Future[Outcome]) -> list[tuple[list[int], BaseException]]:
        """Keeps the rows of a batch, or gives the batch and why there are none."""
        chunks = self.running.pop(future)
        try:
            spent_s, parts = future.result()
            for part in parts:
                self.desk.keep(*part)
        except Exception as error:
            return [(chunks, error)]
        self.spent_s += spent_s
        self.done += len(chunks)
        return []

    def _fail(self, chunks: Sequence[int], error: BaseException) -> None:
        """Ends the campaign with the error of a batch."""
        first, _ = self.desk.runs_of(chunks[0])
        _, end = self.desk.runs_of(chunks[-1])
        left = sum(end - start for start, end in map(self.desk.runs_of, self.desk.missing()))
        kind = type(error) if isinstance(error, GtfdiError) else GtfdiError
        raise kind(
            f"runs {first} to {end - 1}: {str(error) or type(error).__name__}; "
            f"{self.desk.runs - left} of {self.desk.runs} runs are kept in {self.out}, and the same "
            "call goes on from there"
        ) from error
