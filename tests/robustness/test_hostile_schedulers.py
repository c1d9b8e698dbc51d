"""Schedulers that accept and never answer, speak another protocol, or leave in the midst of a sweep."""

from __future__ import annotations

import gc
import importlib
import io
import logging
import random
import shutil
import time

import numpy as np
import pytest
from misbehaving import CLOSE, DEEDS, between, served, wrong_protocol

from amb_cosim.scenario.scenario import Scenario
from amb_sweeps import engine
from amb_sweeps.engine import SETTINGS, ClusterFailed, connect, local_cluster, run_missing
from amb_sweeps.sampling import make_design
from amb_sweeps.store import SweepStore, open_sweep
from amb_sweeps.worker import PointResult, Task

pytestmark = pytest.mark.slow

DESIGN = make_design({"Omega": np.linspace(100.0, 200.0, 40)})
LONGEST = 40.0  # s; those that are given up here are after a few


@pytest.fixture
def impatient(monkeypatch):
    for name, seconds in (("ANSWER_TIME", 1), ("POLITE_TIME", 1), ("START_TIME", 2)):
        monkeypatch.setattr(engine, name, seconds)


def test_what_is_no_scheduler_is_one_message(impatient, first_seed, rounds):
    for seed in range(first_seed, first_seed + rounds):
        begin = time.monotonic()
        refused = pytest.raises(ValueError, match="no Dask scheduler answers at")
        with served(wrong_protocol(random.Random(seed))) as address, refused as caught, connect(f"tcp://{address}"):
            pass
        assert "\n" not in str(caught.value), f"seed {seed}"
        assert time.monotonic() < begin + LONGEST, f"seed {seed}"


@pytest.fixture
def log():
    """What a user would see of Dask's log."""
    text, logger = io.StringIO(), logging.getLogger("distributed")
    handler = logging.StreamHandler(text)
    logger.addHandler(handler)
    yield text
    logger.removeHandler(handler)


@pytest.fixture(scope="module", params=["tcp", "tls"])
def scheduler(request):
    """Protocol, host and port of a scheduler with two workers; with TLS the client's settings have its certificates."""
    import dask
    from distributed import Client
    from distributed.security import Security

    security = Security.temporary() if request.param == "tls" else None
    settings = dict(SETTINGS)
    if security is not None:
        own = security.get_tls_config_for_role("client")
        names = {"ca-file": "ca_file", "client.cert": "cert", "client.key": "key"}
        settings |= {f"distributed.comm.tls.{name}": own[key] for name, key in names.items()}
    with dask.config.set(settings), local_cluster(2, security=security) as cluster:
        protocol, _, place = cluster.scheduler_address.partition("://")
        assert protocol == request.param
        host, _, port = place.rpartition(":")
        with Client(cluster) as client:
            client.run(importlib.import_module, "amb_sweeps.worker")  # which takes some seconds, once
        yield protocol, host, int(port)


def peaks(sweep, task, points):
    """What a worker does in place of runs."""
    return [PointResult(n, "recovered", "", {"peak": 1.0 / (n + 3.0)}, 0.2) for n, _ in points]


def swept(address, folder):
    """Run what a store misses; return whether all points are in it."""
    store = SweepStore(folder, DESIGN, {"a": 1}, {})
    try:
        with connect(address) as client:
            run_missing(client, "sweep", Task(Scenario.load("fig4_9")), store, lambda *_: None)
    except (ValueError, ClusterFailed):
        return False
    return True


@pytest.mark.parametrize("scheduler", ["tls"], indirect=True)
def test_without_its_certificates_a_scheduler_with_tls_lets_nobody_in(impatient, scheduler):
    import dask

    _, host, port = scheduler
    others = dict.fromkeys(("ca-file", "client.cert", "client.key"))
    with dask.config.set({f"distributed.comm.tls.{name}": value for name, value in others.items()}):
        for protocol in ("tls", "tcp"):
            address = f"{protocol}://{host}:{port}"
            with (
                pytest.raises(ValueError, match=f"no Dask scheduler answers at {address}: ") as caught,
                connect(address),
            ):
                pass
            assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_a_sweep_goes_on_after_a_scheduler_that_leaves_at_any_byte(
    impatient, scheduler, log, tmp_path, monkeypatch, first_seed, is_long, rounds
):
    """Points that had come are in the store and right; with a scheduler that works the others come too, in silence."""
    monkeypatch.setattr(engine, "run_batch", peaks)
    protocol, host, port = scheduler
    left = [10**9]
    with served(between(host, port, left, CLOSE)) as address:
        assert swept(f"{protocol}://{address}", tmp_path / "whole")
    total = 10**9 - left[0]  # bytes of a whole sweep
    rounds, failed = rounds if is_long else 2 * len(DEEDS), 0
    for k in range(rounds):
        seed, begin = first_seed + k, time.monotonic()
        left = [int(total * (k + random.Random(seed).random()) / rounds)]
        with served(between(host, port, left, DEEDS[k % len(DEEDS)])) as address:
            failed += not swept(f"{protocol}://{address}", tmp_path / "out")
        assert time.monotonic() < begin + LONGEST, f"seed {seed}"
        assert swept(f"{protocol}://{host}:{port}", tmp_path / "out"), f"seed {seed}"
        result = open_sweep(tmp_path / "out")["peak"].values
        np.testing.assert_array_equal(result, 1.0 / (np.arange(40) + 3.0), err_msg=f"seed {seed}")
        shutil.rmtree(tmp_path / "out")
        gc.collect()
        assert "Traceback" not in log.getvalue(), f"seed {seed}"
    assert failed > rounds / 4
