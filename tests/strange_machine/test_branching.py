"""Points of a sweep of the expander that share the run before an event."""

import numpy as np
import pytest
from strange_machine import RUB

from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.branching import branching_order, varied_labels
from amb_sweeps.sampling import sample_plan
from amb_sweeps.worker import Runner, Task

SHORT = Scenario.load(RUB).changed(end_cycle=11)
SIZE, MOMENT, REMOVED = "step.rotor_contact.turbine.u", "step.cycle", "removal.cycle"
DESIGNS = {
    "what it sets": {SIZE: "60 g.mm:110 g.mm:3"},
    "its moment": {MOMENT: "4:3:4"},
    "a tunable parameter": {"step.rolac_controller.north.c_b_x": [300.0, 600.0]},
    "both events": {REMOVED: [9, 8.5], SIZE: ["90 g.mm", "110 g.mm"], "rotor_contact.shroud.mu": [0.08, 0.1]},
}


def run(vary, order, labels, **options):
    """Return the endings of the points of a design, as text, by number, and the steps that each reused."""
    runner, design = Runner(Task(SHORT, labels=labels, **options)), sample_plan(vary)
    results = {n: runner.run(n, design.settings(n)) for n in order}
    runner.close()
    shared = {n: result.metrics.get("shared", 0.0) for n, result in results.items()}
    endings = {
        n: (r.outcome, r.reason, str({k: v for k, v in r.metrics.items() if k != "shared"})) for n, r in results.items()
    }
    return endings, shared


@pytest.mark.parametrize("vary", list(DESIGNS.values()), ids=list(DESIGNS))
def test_points_with_a_shared_past_have_the_same_bits(vary):
    design = sample_plan(vary)
    points = range(design.size)
    alone, _ = run(vary, points, ())
    together, shared = run(vary, branching_order(design, points, SHORT.labels), varied_labels(design, SHORT.labels))
    assert together == alone
    assert len(set(alone.values())) == design.size, "the points differ"
    parts = 2 if "rotor_contact.shroud.mu" in vary else 1
    assert sum(share == 0.0 for share in shared.values()) == parts
    assert min(share for share in shared.values() if share > 0.0) > 0.7


@pytest.mark.slow
def test_results_of_points_do_not_depend_on_their_order():
    vary = {REMOVED: [9, 8.5], SIZE: ["90 g.mm", "110 g.mm"]}
    labels, points = varied_labels(sample_plan(vary), SHORT.labels), range(4)
    alone, _ = run(vary, points, ())
    for order in ([3, 0, 2, 1], [0, 1, 2, 3], [2, 2, 1, 3, 0]):
        assert run(vary, order, labels)[0] == alone


def test_a_run_that_failed_leaves_no_state_behind():
    vary = {SIZE: ["90 g.mm", "9e9 g.mm", "110 g.mm"]}
    together, shared = run(vary, range(3), ("step",))
    assert [outcome for outcome, *_ in together.values()][1] in ("failed", "invalid")
    assert together[2] == run(vary, [2], ())[0][2]
    assert shared[0] == 0.0


@pytest.mark.slow
def test_stored_records_are_complete_and_equal():
    vary = {SIZE: ["90 g.mm", "110 g.mm"]}
    records = []
    for labels in ((), ("step",)):
        runner, design = Runner(Task(SHORT, keep=("all",), labels=labels)), sample_plan(vary)
        import io

        import xarray as xr

        for n in range(2):
            record = runner.run(n, design.settings(n)).record
            with xr.open_dataset(io.BytesIO(record), engine="h5netcdf") as dataset:
                records.append(dataset.load())
        runner.close()
    for alone, sharing in zip(records[:2], records[2:], strict=True):
        assert set(alone.variables) == set(sharing.variables)
        for name in alone.variables:
            np.testing.assert_array_equal(alone[name].values, sharing[name].values)
        assert alone.attrs["warnings"] == sharing.attrs["warnings"]


def test_branching_order_varies_the_latest_event_fastest():
    vary = {MOMENT: [5, 3, 4], "rotor_contact.shroud.mu": [0.1, 0.2], REMOVED: [9, 8]}
    design = sample_plan(vary)
    assert varied_labels(design, SHORT.labels) == ("step", "removal")
    ordered = [design.settings(n) for n in branching_order(design, range(design.size), SHORT.labels)]
    keys = [(s["rotor_contact.shroud.mu"], s[MOMENT], s[REMOVED]) for s in ordered]
    assert keys == sorted(keys)


def test_without_events_the_order_is_that_of_the_axes():
    design = sample_plan({"Omega": [3, 1, 2], "rotor_contact.shroud.mu": [0.2, 0.1]})
    assert varied_labels(design, SHORT.labels) == ()
    assert branching_order(design, [4, 0, 2], ()) == [4, 0, 2]
