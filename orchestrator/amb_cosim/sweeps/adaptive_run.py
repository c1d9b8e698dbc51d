"""Runs the points that a sampler chooses; while it computes, the processes run its earlier choices."""

from __future__ import annotations

import math
import time
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from amb_cosim.cosim.basics.interruption import Interruption, deferred
from amb_cosim.presentation.progress import SweepReport as Report
from amb_cosim.sweeps.adaptive import Sampler
from amb_cosim.sweeps.engine import BatchScheduler
from amb_cosim.sweeps.worker import Task

if TYPE_CHECKING:
    from distributed import Client

    from amb_cosim.sweeps.store import SweepStore

LONGEST_RESERVE = 20  # waiting points per process


def run_requested(client: Client, sweep: str, task: Task, store: SweepStore, report: Report, sampler: Sampler) -> None:
    """Run points until a sampler reaches its goal; raises the errors of `run_missing` and `Sampler.learn`."""
    with deferred() as interruption, ThreadPoolExecutor(1) as thinker:
        _Adaptive(client, sweep, task, store, report, interruption, sampler, thinker).run()


class _Adaptive(BatchScheduler):
    """Points requested by a sampler. Enough wait to keep all processes busy until its next choice."""

    def __init__(
        self,
        client: Client,
        sweep: str,
        task: Task,
        store: SweepStore,
        report: Report,
        interruption: Interruption,
        sampler: Sampler,
        thinker: ThreadPoolExecutor,
    ) -> None:
        super().__init__(client, sweep, task, store, report, interruption)
        self._waiting.clear()
        self._total = self._done
        self._sampler, self._thinker = sampler, thinker
        self._thought: Future[Any] | None = None
        self._began = self._took = 0.0  # duration of a choice (s)
        self._has_result, self._has_news = False, True

    def _refill(self) -> bool:
        """Take the points of a finished choice; start the next if too few points wait."""
        if self._thought is not None and self._thought.done():
            requested, self._has_result = self._thought.result()
            self._has_news = self._has_news or bool(requested)
            self._thought, self._took = None, time.monotonic() - self._began
            self._waiting.extend(requested)
            self._total += len(requested)
        if self._thought is None and self._has_news and not self._has_result:
            threads = max(1, self._threads())
            each = self._seconds / self._ran if self._ran else math.inf
            reserve = threads * min(LONGEST_RESERVE, 1 + math.ceil(self._took / each))
            if len(self._waiting) < reserve:
                pending = {*self._waiting, *self._suspects, *(n for points in self._under_way.values() for n in points)}
                self._began, self._has_news = time.monotonic(), False
                count = reserve - len(self._waiting)
                self._thought = self._thinker.submit(self._sampler.next_points, count, pending)
        return not self._has_result

    def _store_results(self, results: Any) -> None:
        super()._store_results(results)
        self._has_news = True
        self._sampler.learn(results)

    def _next_batch(self) -> list[int]:
        return [self._waiting.popleft()]

    def _tell(self) -> None:
        """Report progress relative to the requested points."""
        self._report(self._done, max(self._total, self._done), str(self._client.dashboard_link or ""))
