"""Sends the points of a sweep in batches to the processes of a Dask cluster, and collects the results.

A batch takes about `BATCH_TIME`; its size follows from the time that earlier points took. Each process runs one batch
at a time, so only the points of this batch can be the cause of a crash. Dask repeats the batch once. If the repetition
also crashes a process, the points are run one by one. A point that crashes two processes on its own is recorded as
`crashed`.

Processes of a local cluster use TLS, with certificates that are created for this cluster and stay in memory. Without
TLS, all users of the machine could connect to 127.0.0.1, and a scheduler runs code for anyone who can connect.
"""

from __future__ import annotations

import asyncio
import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from amb_analysis.studies.processes import check_script, main_guard_advice
from amb_cosim.cosim.processes.interruption import Interruption, deferred
from amb_sweeps.branching import branching_order
from amb_sweeps.outcomes import BROKEN_OFF
from amb_sweeps.sweep_bar import Report
from amb_sweeps.worker import PointResult, Task, run_batch

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

    from amb_sweeps.store import SweepStore

T = TypeVar("T")

BATCH_TIME = 1.0  # s
LARGEST_BATCH = 500  # points
WRITE_TIME = 5.0  # s between two writes of the store, for any number of processes
POLL = 0.25  # s until an interruption is noticed
START_TIME = 120  # s until a process of the cluster has started
ANSWER_TIME = 10  # s until a scheduler answers
POLITE_TIME = 2  # s for repeated requests to a scheduler, and for a client to disconnect
SETTINGS = {
    "distributed.admin.tick.interval": "1s",  # waiting processes would use a twentieth of a core at the default, 20 ms
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.allowed-failures": 1,
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.daemon": True,
    "distributed.worker.profile.enabled": False,  # a profiler that samples every worker a hundred times per second
    "distributed.comm.retry.count": 0,
    # Freed memory is kept for the next run. With Dask's 64 kB, glibc returns it and the kernel clears it again.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 2**26,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 2**25,
}


class ClusterFailed(Exception):
    """The cluster ended before the sweep was complete."""


class MetricFailed(ValueError):
    """A user's metric cannot evaluate the first runs because of an error that other runs share."""


@contextmanager
def connect(scheduler: str | None = None, jobs: int | None = None) -> Iterator[Client]:
    """Connect to the scheduler at an address, or start a local cluster of `jobs` processes with one thread each.

    Raises
    ------
    ValueError
        If no scheduler answers at this address.
    """
    import dask
    from distributed import Client
    from distributed.utils import silence_logging_cmgr

    if scheduler is not None and jobs is not None:
        raise ValueError("`jobs` is for a local cluster; a scheduler's workers are started separately")
    if jobs is not None and jobs < 1:
        raise ValueError(f"jobs = {jobs} is not allowed; it must be 1 or more")
    with dask.config.set(SETTINGS), silence_logging_cmgr(logging.CRITICAL):  # failures are reported as one message
        if scheduler is None:
            with local_cluster(jobs) as cluster, Client(cluster) as client:
                yield client
            return
        try:
            _check_answer(scheduler)
            client = _within(4 * ANSWER_TIME, lambda: Client(scheduler, timeout=ANSWER_TIME))  # in many steps
        except Exception as error:  # each protocol has its own errors
            why = str(error) or f"it did not respond within {ANSWER_TIME} s"
            raise ValueError(f"no Dask scheduler answers at {scheduler}: {why}") from error
        try:
            with client.as_current():  # otherwise Dask waits in the event loop of the caller's client
                yield client
        finally:
            try:
                client.close(timeout=POLITE_TIME)
            except Exception:  # a scheduler that has ended, possibly during its last message
                client.status = "closed"  # otherwise garbage collection repeats it and prints a traceback


def local_cluster(jobs: int | None, security: bool | None = True) -> LocalCluster:
    """Start processes with one thread each; if `security` is true, they require the cluster's certificates.

    Raises
    ------
    ClusterFailed
        If the processes end while they start.
    ValueError
        If the processes cannot import the script that Python runs.
    """
    from distributed import LocalCluster

    check_script()

    try:
        return LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
            preload=["amb_sweeps.local_worker"],
            silence_logs=logging.CRITICAL,  # a crashed process is reported as the outcome of its points
            security=security,
        )
    except RuntimeError as error:
        raise ClusterFailed(
            f"no process of the sweep started ({error.__cause__ or error}); {main_guard_advice('sweep')}"
        ) from None


def _check_answer(scheduler: str) -> None:
    """Raise Dask's error or TimeoutError if no scheduler responds at an address; a Dask client would keep waiting."""
    from distributed.core import rpc
    from distributed.security import Security

    async def ask() -> None:
        async with rpc(scheduler, connection_args=Security().get_connection_args("client")) as remote:
            await asyncio.wait_for(remote.identity(), ANSWER_TIME)

    _within(4 * ANSWER_TIME, lambda: asyncio.run(ask()))


def _within(seconds: float, call: Callable[[], T]) -> T:
    """Return the result of a call, or raise TimeoutError; a call that never returns blocks only its own thread.

    The call runs in its own thread, because the caller's thread may have an event loop. A Dask client can wait forever
    while it starts, despite its time limit, if the scheduler disconnects or another client is garbage-collected.
    """
    outcome: futures.Future[T] = futures.Future()

    def run() -> None:
        try:
            outcome.set_result(call())
        except BaseException as error:
            outcome.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return outcome.result(seconds)


def run_missing(client: Client, sweep: str, task: Task, store: SweepStore, report: Report) -> None:
    """Run the points that a store lacks, and store results as they arrive.

    Raises
    ------
    KeyboardInterrupt
        If a signal interrupts the process; earlier results are in the store.
    ClusterFailed
        If the cluster has ended, or has no process.
    MetricFailed
        If a metric fails in the first runs, with an error of the function itself; no result is stored.
    """
    with deferred() as interruption:
        BatchScheduler(client, sweep, task, store, report, interruption).run()


class BatchScheduler:
    """The running batches of a sweep, and the waiting points."""

    def __init__(
        self, client: Client, sweep: str, task: Task, store: SweepStore, report: Report, interruption: Interruption
    ) -> None:
        import cloudpickle

        self._client, self._sweep, self._store = client, sweep, store
        self._task = cloudpickle.dumps(task)  # functions of a file are pickled by value; Dask would do so by name
        self._report, self._interruption = report, interruption
        self._waiting = deque(branching_order(store.design, store.missing, task.labels))
        self._suspects: deque[int] = deque()  # points of batches that crashed processes
        self._running: dict[Future[Any], list[int]] = {}
        self._unwritten: list[PointResult] = []  # since the store was last written
        self._written = -math.inf
        self._done, self._total = store.design.size - len(self._waiting), store.design.size
        self._seconds, self._finished = 0.0, 0
        self._link = self._dashboard()
        self._is_judged = not task.metrics or self._done > 0  # whether the metrics have been applied to a run

    def run(self) -> None:
        try:
            self._run()
        except BaseException:
            with suppress(Exception):
                if self._threads():  # otherwise there is no answer
                    self._client.cancel(list(self._running))
            raise
        finally:
            self._write()

    def _run(self) -> None:
        alive = time.monotonic()
        self._report_progress()
        while self._waiting or self._suspects or self._running:
            self._interruption.check()
            if self._client.status == "closed":
                raise ClusterFailed("the scheduler was stopped")
            workers = self._threads()
            alive = time.monotonic() if workers else alive
            if time.monotonic() > alive + START_TIME:
                raise ClusterFailed(f"the scheduler had no worker or did not answer for {START_TIME} s")
            while len(self._running) < workers and (self._waiting or self._suspects):
                self._submit()
            if time.monotonic() > self._written + WRITE_TIME:
                self._write()  # while the processes are busy
            self._collect()

    def _store_results(self, results: Sequence[PointResult]) -> None:
        """Store the results of points, unless a metric can evaluate none of the first ones."""
        errors = [result.metric_error for result in results if result.outcome not in BROKEN_OFF]
        if errors and not self._is_judged:
            general = [error.text for error in errors if error and error.is_general]
            if len(general) == len(errors):
                raise MetricFailed(f"{general[0]}; the sweep ends at its first run, and nothing is stored")
            self._is_judged = True
        self._unwritten += results
        self._done += len(results)
        self._report_progress()

    def _threads(self) -> int:
        """Return the number of batches that can run at once; 0 if there is no connection or no answer."""
        return sum(self._ask("ncores").values())  # called by `nthreads`, which would wait forever

    def _ask(self, question: str, **arguments: Any) -> dict[Any, Any]:
        """Return the answer of the scheduler; it is empty if there is no connection or no answer."""
        scheduler = self._client.scheduler
        if self._client.status == "running" and scheduler is not None:
            with suppress(Exception):
                ask = getattr(scheduler, question)
                return dict(self._client.sync(ask, callback_timeout=POLITE_TIME, **arguments))
        return {}

    def _submit(self) -> None:
        points = [self._suspects.popleft()] if self._suspects else self._next_batch()
        batch = [(n, self._store.design.settings(n)) for n in points]
        future = self._client.submit(run_batch, self._sweep, self._task, batch, pure=False)
        self._running[future] = points

    def _next_batch(self) -> list[int]:
        """Return points that together take about `BATCH_TIME`; fewer at the end, so that no process finishes late."""
        size = int(BATCH_TIME * self._finished / self._seconds) if self._seconds > 0.0 else 1
        share = len(self._waiting) // (2 * max(1, self._threads()))
        return [
            self._waiting.popleft() for _ in range(min(len(self._waiting), LARGEST_BATCH, max(1, size), share or 1))
        ]

    def _collect(self) -> None:
        """Wait for results, and store all that are available."""
        from distributed import wait

        if not self._running:
            time.sleep(POLL)
            return
        with suppress(TimeoutError, CancelledError):
            wait(list(self._running), timeout=POLL, return_when="FIRST_COMPLETED")
        results: list[PointResult] = []
        for future in [future for future in self._running if future.done()]:
            results += self._results(future, self._running.pop(future))
        if results:
            self._store_results(results)

    def _write(self) -> None:
        if self._unwritten:
            self._store.add(self._unwritten)
            self._unwritten, self._written = [], time.monotonic()

    def _results(self, future: Future[Any], points: Sequence[int]) -> list[PointResult]:
        """Return the results of a batch; points that must be repeated are queued."""
        from distributed import KilledWorker

        if future.status == "finished":
            with suppress(Exception):  # a scheduler that ends while answering, or gives an invalid answer
                batch: list[PointResult] = future.result(timeout=START_TIME)
                self._seconds += sum(result.seconds for result in batch)
                self._finished += len(batch)
                return batch
        if future.status != "error":  # cancelled, or lost with the scheduler
            self._waiting.extend(points)
            return []
        error = future.exception()
        if not isinstance(error, KilledWorker):
            raise ClusterFailed(f"a worker cannot run the sweep: {type(error).__name__}: {error}") from error
        if len(points) > 1:
            self._suspects.extend(points)
            return []
        return [PointResult(points[0], "crashed", "the process of the run ended unexpectedly twice")]

    def _report_progress(self) -> None:
        self._report(self._done, self._total, self._link)

    def _dashboard(self) -> str:
        """Return the address of the dashboard; Dask's own function would repeat its request without end."""
        from distributed.utils import format_dashboard_link

        if self._client.cluster is not None:
            return str(self._client.dashboard_link or "")
        scheduler = self._ask("identity")
        port = scheduler.get("services", {}).get("dashboard")
        host = str(scheduler.get("address", "")).rpartition("://")[2].rpartition(":")[0]
        return str(format_dashboard_link(host, port)) if port else ""
