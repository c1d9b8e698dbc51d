"""Contact of a machine whose retainers are not in its bearings, and forces between samples."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.results import contact_forces, contact_history, orbits
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.places import RotorPlaces, places_of
from amb_cosim.results.plots.axes import site_title, stations
from rotor_analysis.parts import Bearing, Sensor, Site
from source_check import run_quantities

H, N = 50e-6, 401
CLEARANCE = 0.2e-3
PLACES = RotorPlaces({"drive_end": "catcher", "thrust": ""}, ("catcher", "seal"), apart=("catcher",))
SILENT = {f"{site}.{name}": np.zeros(N) for site in PLACES.sites for name in ("f_n", "impulse", "mode")}


def table(values, found=PLACES, every=1, **parameters):
    """Return a run of 20 ms at 20 kHz, 2 cycles, in which every `every`-th sample is recorded."""
    time = H * np.arange(N)[::every]
    settings = {"catcher.clearance": CLEARANCE, "seal.clearance": CLEARANCE} | parameters
    return SignalTable(
        {f"{PLANT}.{name}": Samples(np.asarray(value, float)[::every], {}) for name, value in values.items()},
        {"time": Samples(time, {}), "cycle": Samples(time / 0.01, {})},
        {
            "places": found.to_json(),
            "scenario": "compressor",
            "parameters": json.dumps({PLANT: settings}),
            "communication_step_s": H,
            "speed_rad_s": 628.0,
            "period_s": 0.01,
        },
    )


def whirl(radius):
    angle = 2.0 * np.pi * np.arange(N) * H / 0.01
    return radius * np.cos(angle), radius * np.sin(angle)


def moving(bearing, site):
    """The rotor whirls with different radii at the bearing and in its retainer."""
    (x, y), (x_s, y_s), (x_t, y_t) = whirl(bearing), whirl(site), whirl(5e-5)
    return SILENT | {
        "drive_end.x": x,
        "drive_end.y": y,
        "catcher.x": x_s,
        "catcher.y": y_s,
        "thrust.x": x_t,
        "thrust.y": y_t,
        "contact_state": np.zeros(N),
    }


def test_peak_is_the_largest_force_within_a_step():
    steps = np.where(np.arange(N) == 200, 900.0, 0.0)
    run = table(SILENT | {"seal.f_n_peak": steps, "seal.f_n_mean": 0.4 * steps})
    assert contact_forces.peak_force(run, "seal") == 900.0
    assert not contact_forces.is_sampled(run, "seal")
    assert contact_forces.peak_force(run, "seal", begin=1.5) == 0.0
    assert contact_history.touchable(run) == ["catcher", "seal"]


def test_forces_known_only_at_samples_are_marked():
    force = np.where(np.arange(N) == 200, 500.0, 0.0)
    run = table(SILENT | {"seal.f_n": force})
    assert contact_forces.peak_force(run, "seal") == 500.0
    assert contact_forces.is_sampled(run, "seal")
    assert contact_forces.is_sampled(table(SILENT | {"seal.f_n_peak": force}, every=3), "seal")


@pytest.mark.parametrize("known", [True, False], ids=["means of steps", "samples and impacts"])
def test_impulse_is_that_of_forces_and_impacts(known):
    """100 N throughout, and an impact of 0.3 N s: 300 N over a millisecond."""
    impact = np.where(np.arange(N) == 100, 0.3, 0.0)
    values = {"seal.f_n": np.full(N, 100.0), "seal.impulse": impact}
    run = table(SILENT | values | ({"seal.f_n_mean": 100.0 + impact / H} if known else {}))
    assert contact_forces.received_impulse(run, "seal")[-1] == pytest.approx(100.0 * 0.02 + 0.3)
    assert contact_forces.largest_averaged_force(run, "seal") == pytest.approx(400.0)


def test_an_empty_run_has_no_impulse():
    empty = table({name: [] for name in SILENT})
    none = SignalTable(empty.variables, {name: Samples(np.zeros(0), {}) for name in ("time", "cycle")}, empty.attrs)
    assert len(contact_forces.received_impulse(none, "seal")) == 0
    assert contact_forces.peak_force(none, "seal") is None


def test_contact_between_two_samples_counts():
    run = table(moving(1e-4, 1e-4) | {"seal.f_n_peak": np.where(np.arange(N) == 200, 900.0, 0.0)})
    assert contact_history.contact_cycles(run) == pytest.approx((1.0, 1.0))


def test_orbits_in_a_retainer_and_its_bearing_are_both_reported():
    run = table(moving(1.0e-4, 1.7e-4))
    assert orbits.orbit_largest(run) == pytest.approx({"drive_end": 0.1, "thrust": 0.05, "catcher": 0.17})
    assert run_quantities.largest_radius(run, "drive_end") == pytest.approx(0.85)
    assert [(s.place, s.site) for s in stations(run)] == [("catcher", "catcher"), ("thrust", "")]


def test_a_retainer_without_a_path_has_that_of_its_bearing():
    """Which counts from the rest; the retainer's centre is 30 um aside and its housing moves."""
    values = moving(1.0e-4, 0.0) | {"catcher.housing_x": np.linspace(0.0, 2e-5, N), "catcher.housing_y": np.zeros(N)}
    of_bearing = {name: value for name, value in values.items() if name not in ("catcher.x", "catcher.y")}
    run = table(of_bearing, **{"catcher.offset_x": 3e-5})
    x, y = orbits.path(run, "catcher")
    np.testing.assert_allclose(x, values["drive_end.x"] - 3e-5 - values["catcher.housing_x"], atol=1e-18)
    np.testing.assert_allclose(y, values["drive_end.y"], atol=1e-18)
    np.testing.assert_allclose(orbits.path_at_rest(run, "catcher")[0], values["drive_end.x"], atol=1e-18)


def places_with(*sites):
    """Return the places of a rotor with two bearings, one of them magnetic, as its FMU states them."""
    from machines import machine

    from amb_cosim.model_constants.plant_data import plant

    bearings = (Bearing("drive_end", 2), Bearing("thrust", 24))
    model, _ = plant(machine(bearings=bearings, sites=sites, sensors=(Sensor("probe", 5),)))
    fmu = SimpleNamespace(layout=json.loads(json.dumps(model.layout)))
    system = SimpleNamespace(fed=lambda: {f"{PLANT}.drive_end.f_x", f"{PLANT}.speed"})
    return places_of(SimpleNamespace(interfaces={PLANT: None}, fmus={PLANT: fmu}, system=system))


def test_contact_in_a_bearing_is_that_of_any_of_its_retainers():
    """The plant's `contact_state` has a bit for each bearing, which either of its retainers sets."""
    inner, outer = (Site(name, node, CLEARANCE, bearing="drive_end") for name, node in (("inner", 2), ("outer", 3)))
    result = places_with(inner, outer, Site("seal", 5, CLEARANCE))
    assert result.contact_states == ("none", "inner or outer", "thrust", "both")
    run = table(moving(0.0, 0.0), result)
    titles = [site_title(run, site).replace("\N{NO-BREAK SPACE}", " ") for site in ("inner", "outer", "seal")]
    assert titles == [
        "Retainer inner at $z$ = 0.1 m",
        "Retainer outer at $z$ = 0.2 m",
        "Contact site seal at $z$ = 0.4 m",
    ]


@pytest.mark.parametrize(("node", "apart"), [(2, ()), (3, ("catcher",))])
def test_a_retainer_in_another_plane_than_its_bearing_is_separate(node, apart):
    result = places_with(Site("catcher", node, CLEARANCE, bearing="drive_end"))
    assert result.apart == apart
    assert result.bearings == {"drive_end": "catcher", "thrust": ""}
    assert result.magnetic == ("drive_end",)
