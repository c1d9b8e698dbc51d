"""Sweeps on a local cluster: stored data, resumption, and points that fail."""

import os
import platform
import signal

import numpy as np
import pytest
import xarray as xr
from distributed import Client, default_client

import amb_cosim
from amb_sweeps.engine import connect
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore, open_sweep
from amb_sweeps.worker import PointResult, Runner, Task
from tests.amb_sweeps.conftest import UNTIL, VARY, same
from tests.support.messages import raises_naming


@pytest.fixture(scope="module")
def sweep(cluster, small):
    """`sweep(folder, **options)`: nine points on the module's cluster."""

    def run(folder, **options):
        values = {"vary": VARY, "until": UNTIL, "scheduler": cluster, "progress": False} | options
        return amb_cosim.sweep(small, output=folder, **values)

    return run


@pytest.fixture(scope="module")
def undisturbed(sweep, tmp_path_factory):
    return sweep(tmp_path_factory.mktemp("undisturbed")).dataset


def test_a_store_opens_with_labels_units_and_provenance(undisturbed, sweep, tmp_path):
    sweep(tmp_path)
    with xr.open_zarr(tmp_path / "sweep.zarr") as dataset:
        assert dict(dataset.sizes) == {"Omega": 3, "rotor_contact.d1.u": 3}
        assert dataset["rotor_contact.d1.u"].attrs["units"] == "g.m"
        assert dataset["peak_contact_force"].attrs["units"] == "N"
        assert '"amb-cosim"' in dataset.attrs["provenance"]
        assert '"design"' in dataset.attrs["request"]
        assert float(dataset["contact"].sum()) not in (0.0, 9.0)
        assert ((dataset["outcome"] == "undecided") == (dataset["recovered"] == 0.0)).all()
        assert ((dataset["outcome"] == "completed") == dataset["recovered"].isnull()).all()  # touched nothing
        same(dataset.load(), undisturbed)


def test_the_cluster_gives_the_same_as_this_process(undisturbed, small):
    runner, design = Runner(Task(small, until=UNTIL)), sample_plan(VARY)
    for n in reversed(range(design.size)):
        metrics = runner.run(n, design.settings(n)).metrics
        for name, value in metrics.items():
            np.testing.assert_array_equal(undisturbed[name].values.ravel()[n], value, err_msg=name)
    runner.close()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="concerns the memory allocation of glibc")
def test_processes_of_a_sweep_keep_the_memory_that_a_run_frees(cluster):
    def faults() -> int:
        import resource

        def touch() -> int:
            np.ones(2**18)  # 2 MB, or 512 pages
            return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

        first = touch()
        return max(touch() for _ in range(10)) - first

    with Client(cluster) as client:
        assert client.submit(faults, pure=False).result(timeout=60) < 512


def test_a_sweep_resumes_with_the_missing_points(undisturbed, sweep, tmp_path):
    seen = []

    def stop(done, total, dashboard):
        seen.append(done)
        if done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(tmp_path, progress=stop)
    interrupted = open_sweep(tmp_path)
    before = interrupted["seconds"].values[interrupted["outcome"].values != ""]
    assert 3 <= len(before) < 9
    seen.clear()
    sweep(tmp_path, progress=lambda done, total, dashboard: seen.append(done))
    assert seen[0] == len(before)
    assert seen[-1] == 9
    same(open_sweep(tmp_path), undisturbed)
    assert set(before) <= set(open_sweep(tmp_path)["seconds"].values.ravel())


@pytest.mark.slow
def test_only_one_process_writes_to_a_folder(sweep, tmp_path):
    from amb_sweeps.run import only_writer

    with only_writer(tmp_path), pytest.raises(ValueError, match="another sweep is writing"):
        sweep(tmp_path)


def crash_at_220(result):
    if abs(float(result.dataset.attrs["speed_rad_s"]) - 220.0) < 1e-9:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"survived": 1.0}


@pytest.mark.slow
def test_a_crash_loses_its_point_alone(sweep, tmp_path):
    metrics = [crash_at_220]
    swept = sweep(tmp_path, vary={"Omega": "200:240 rad/s:5"}, metrics=metrics)
    outcomes = dict(zip(swept.dataset["Omega"].values, swept.dataset["outcome"].values, strict=True))
    assert outcomes.pop(220.0) == "crashed"
    assert set(outcomes.values()) == {"completed"}
    assert "twice" in str(swept.dataset["reason"].sel(Omega=220.0).values)


@pytest.mark.slow
@pytest.mark.gate
def test_full_records_of_chosen_points_are_kept(sweep, tmp_path):
    sweep(tmp_path, vary={"Omega": [200.0, 210.0]}, keep=["completed"])
    names = sorted(path.name for path in (tmp_path / "runs").iterdir())
    assert names == ["grid_0.nc", "grid_1.nc"]
    result = amb_cosim.Result.load(tmp_path / "runs" / "grid_1.nc")
    assert result.dataset.attrs["speed_rad_s"] == 210.0


@pytest.mark.slow
def test_refinement_finds_the_boundary_with_few_runs(sweep, tmp_path):
    tolerance = 0.02
    vary = {"rotor_contact.d1.u": "5 g.m:60 g.m:3"}
    swept = sweep(tmp_path, vary=vary, sample="boundary:contact", certainty=tolerance)
    result = open_sweep(tmp_path, "boundary_contact")
    assert result.sizes["point"] == 1
    u, error = float(result["rotor_contact.d1.u"][0]), float(result["uncertainty"][0])
    assert error <= tolerance * 55.0 / 2.0
    runner = Runner(Task(amb_cosim.Scenario.load("fig4_9").changed(settle_cycles=2), until=UNTIL))
    sides = [runner.run(0, {"rotor_contact.d1.u": f"{u + side * error} g.m"}).metrics["contact"] for side in (-1, 1)]
    assert sides == [0.0, 1.0]
    assert sorted(swept.dataset["contact"].values) == list(swept.dataset["contact"].values)


def test_a_wrong_value_is_refused_before_anything_runs(sweep, tmp_path):
    with pytest.raises(ValueError, match=r"rotor_contact.rb1.clearance = -0.001 m"):
        sweep(tmp_path, vary={"rotor_contact.rb1.clearance": "-1 mm:1 mm:3"})
    with pytest.raises(ValueError, match="clearence"):
        sweep(tmp_path, vary={"rotor_contact.rb1.clearence": "1 mm:2 mm:3"})
    assert not (tmp_path / "sweep.zarr").exists()


def test_a_missing_scheduler_is_an_input_error(small, tmp_path, monkeypatch):
    monkeypatch.setattr("amb_sweeps.engine.ANSWER_TIME", 1)
    with pytest.raises(ValueError, match="no Dask scheduler answers at tcp:"):
        amb_cosim.sweep(small, VARY, until=UNTIL, output=tmp_path, scheduler="tcp://127.0.0.1:9", progress=False)
    with raises_naming(ValueError, "jobs", "cluster"):
        amb_cosim.sweep(small, VARY, until=UNTIL, output=tmp_path, scheduler="tcp://127.0.0.1:9", jobs=2)


def test_a_sweep_waits_with_its_own_client_beside_one_of_the_caller(cluster):
    with Client(cluster) as theirs:
        with connect(cluster) as ours:
            assert default_client() is ours
        assert default_client() is theirs


@pytest.mark.parametrize("size", [1, 7, 40000])
def test_a_store_is_read_as_it_was_written(tmp_path, size):
    design = sample_plan({"Omega": np.arange(1.0, size + 1.0), "x.y": ["a", "b"]})
    store = SweepStore(tmp_path, design, {"a": 1}, {})
    last = design.size - 1
    store.add([PointResult(last, "failed", "why", {}, 1.0), PointResult(0, "trapped", "", {"m": 0.1, "n": 2.0}, 2.0)])
    again = SweepStore(tmp_path, design, {"a": 1}, {})
    assert len(again.missing) == design.size - len({0, last})
    dataset = open_sweep(tmp_path)
    assert dataset["outcome"].values.ravel()[[0, last]].tolist() == ["trapped", "failed"]
    assert (dataset["m"].values.ravel()[0], dataset["reason"].values.ravel()[last]) == (0.1, "why")
    assert np.isnan(dataset["m"].values.ravel()[last])


def test_a_sweep_is_a_table_of_pandas_with_a_row_for_each_point(sweep, tmp_path):
    swept = sweep(tmp_path)
    table = swept.to_dataframe()
    assert len(table) == swept.dataset["outcome"].size
    assert {*swept.dataset.dims} <= {*table.columns}
    assert list(table["outcome"]) == list(swept.dataset["outcome"].values.ravel())
    assert all(outcome in swept._repr_html_() for outcome in swept.outcomes)
