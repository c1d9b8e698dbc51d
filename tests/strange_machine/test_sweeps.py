"""Sweeps of the expander: every site counts, and so does every run that failed."""

import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from strange_machine import RUB

from amb_cosim.commands.cli import main
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.maps import draw_map
from amb_sweeps.phases import distribution, draw_distribution
from amb_sweeps.run import Sweep
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore
from amb_sweeps.worker import PointResult, Runner, Task

PEAK = "averaged_contact_force"


@pytest.fixture(scope="module")
def point() -> PointResult:
    runner = Runner(Task(Scenario.load(RUB)))
    result = runner.run(0, {})
    runner.close()
    return result


def test_contact_at_seal_and_turbine_is_counted(point, rub):
    at_sites = {site: point.metrics[f"{PEAK}.{site}"] for site in ("catch_n", "catch_s", "labyrinth", "shroud")}
    touched = {site: force for site, force in at_sites.items() if force > 0.0}
    assert touched == pytest.approx({s: f for s, f in rub.summary.averaged_contact_force.items() if f}, rel=1e-12)
    assert point.metrics[PEAK] == at_sites["labyrinth"] == max(at_sites.values())


def filled(folder, vary, results) -> Sweep:
    """Return a sweep with these results in its order; None is a run that failed."""
    design = sample_plan(vary)
    store = SweepStore(folder, design, {"scenario": {"name": "made up"}}, {})
    store.add(
        [
            PointResult(n, "failed", "no power") if result is None else PointResult(n, "recovered", "", result)
            for n, result in enumerate(results)
        ]
    )
    return Sweep(folder, design)


def peaks_at(labyrinth: float, catch: float) -> dict[str, float]:
    return {f"{PEAK}.catch_n": catch, f"{PEAK}.labyrinth": labyrinth, PEAK: max(labyrinth, catch)}


def test_the_summary_names_the_site_of_the_largest_force(tmp_path):
    swept = filled(tmp_path, {"a.x": "1:3:3"}, [peaks_at(3.0, 4.0), peaks_at(9.0, 4.0), peaks_at(2.0, 5.0)])
    assert (
        swept.summary
        == "3 runs, 3 recovered; largest contact force (1 ms mean with impacts) up to 9 N at labyrinth, with x = 2"
    )


def test_a_sweep_without_a_run_that_succeeded_ends_with_exit_code_1(tmp_path, monkeypatch):
    swept = filled(tmp_path / "store", {"a.x": "1:3:3"}, [None, None, None])
    monkeypatch.setattr("amb_sweeps.run.sweep", lambda *_, **__: swept)
    arguments = ["sweep", str(RUB), "--vary", "a.x=1:3:3", "--no-plots", "-o", str(tmp_path)]
    ended = CliRunner().invoke(main, arguments)
    assert (ended.exit_code, ended.stdout.splitlines()[0]) == (1, "3 runs, 3 failed")
    assert "no run of the sweep succeeded" in ended.stderr


@pytest.mark.slow
def test_error_of_a_script_without_a_main_guard_requires_it(tmp_path):
    script = tmp_path / "script.py"
    call = f"amb_cosim.sweep({str(RUB)!r}, {{'Omega': ['300 rad/s']}}, output='out', until='1 ms', jobs=1)"
    script.write_text(f"import amb_cosim\n{call}\n")
    ended = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert 'if __name__ == "__main__":' in ended.stderr.splitlines()[-1]
    assert ended.stderr.count("Traceback") == 1


def test_the_summary_begins_with_runs_that_failed(tmp_path):
    first = filled(tmp_path, {"a.x": "1:3:3"}, [peaks_at(3.0, 4.0), None, peaks_at(2.0, 5.0)]).summary.splitlines()[0]
    force = "largest contact force (1 ms mean with impacts), unknown for aborted runs, up to 5 N"
    assert first.startswith(f"3 runs, 1 failed, 2 recovered; {force}")


def crosses(figure) -> list[tuple[float, ...]]:
    """Return the points of a figure that are marked as failed."""
    lines = [line for ax in figure.axes for line in ax.lines if line.get_marker() == "x"]
    return [tuple(xy) for line in lines for xy in np.column_stack(line.get_data()).tolist()]


def legend_texts(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_a_map_has_a_cross_where_a_run_failed(tmp_path):
    results = [None if k in (2, 5) else peaks_at(1.0 + k, 0.0) for k in range(6)]
    swept = filled(tmp_path, {"a.x": "1:2:2", "a.y": "10:30:3"}, results)
    figure = draw_map(swept, swept.dataset, PEAK)
    assert sorted(crosses(figure)) == [(1.0, 30.0), (2.0, 30.0)]
    assert legend_texts(figure) == ["failed: 2 of 6"]


def test_a_map_over_one_axis_has_its_crosses_above_all_values(tmp_path):
    swept = filled(tmp_path, {"a.x": "1:3:3"}, [peaks_at(3.0, 4.0), None, peaks_at(2.0, 5.0)])
    assert crosses(draw_map(swept, swept.dataset, PEAK)) == [(2.0, 1.0)]


def test_a_failed_run_is_the_worst_of_its_phase(tmp_path):
    """Of five runs at each phase one, then three fail: the extreme, then also the median, exceed all values."""
    forces = np.arange(1.0, 6.0)
    results = [peaks_at(force, 0.0) for force in forces]
    results += [None, *results[1:], None, None, None, *results[3:]]
    swept = filled(tmp_path, {"step.cycle": "5:5.5:3", "a.x": "1:5:5"}, results)
    result = distribution(swept.dataset, "step.cycle")
    np.testing.assert_allclose(result[:, 0], forces)
    np.testing.assert_allclose(result[:, 1], [2.0, 3.0, 4.0, 5.0, np.inf])
    np.testing.assert_allclose(result[:, 2], [4.0, 5.0, np.inf, np.inf, np.inf])
    figure = draw_distribution(swept, swept.dataset, "step.cycle")
    assert {x for x, _ in crosses(figure)} == {90.0, 180.0}
    assert "failed: 4 of 15" in legend_texts(figure)
    bottom, top = figure.axes[0].get_ylim()
    assert (bottom, top > forces.max()) == (0.0, True)
