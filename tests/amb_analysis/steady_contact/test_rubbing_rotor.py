"""The rotor of a run for the analysis of steady rub: its speed, and the sites that it can touch."""

from dataclasses import replace

import numpy as np
import pytest

from amb_analysis.steady_contact import rubbing_rotor as module
from amb_analysis.steady_contact.contact_whirl import contact_whirls
from amb_analysis.steady_contact.rolling import rolling
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.trap_map import least_trapping_at
from amb_analysis.studies import contact_traps
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.parts import Site
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names

COMPRESSOR = "compressor_levitated"


def rubbing(*more, **fields):
    rotor = load_rotor("compressor")
    scenario = load_scenario(COMPRESSOR).changed(rotor=replace(rotor, sites=(*rotor.sites, *more)), **fields)
    return rubbing_rotor(prepare_run(scenario))


@pytest.fixture(scope="module")
def plane():
    """Node and clearance of the first retainer, `td1`."""
    site = load_rotor("compressor").sites[0]
    return site.node, site.clearance


@pytest.mark.parametrize(("ratio", "left_out"), [(1.3, "bush"), (1.0, "bush"), (0.7, "td1")])
def test_only_the_narrowest_site_of_a_plane_is_touched(plane, ratio, left_out):
    """Receptances of two sites in one plane are singular, so how they share a force is undetermined."""
    node, clearance = plane
    rotor = rubbing(Site("bush", node, ratio * clearance))
    assert set(rotor.sites) == {"td1", "td2", "seal", "bush"} - {left_out}
    assert len(rotor.c) == len(rotor.records) == 3
    assert_names(" ".join(rotor.notes), left_out, "left out")


def test_whirl_and_rolling_of_two_sites_in_a_plane_are_those_of_one(plane):
    node, clearance = plane
    alone, beside = rubbing(), rubbing(Site("bush", node, 1.3 * clearance))
    Omega = alone.Omega
    for states in (contact_whirls, rolling):
        first, second = states(alone, Omega), states(beside, Omega)
        assert [state.contact for state in first] == [state.contact for state in second]
    assert pytest.approx(alone.receptances(Omega).R) == beside.receptances(Omega).R


def test_small_motion_at_a_speed_is_prepared_once_for_all_factors(monkeypatch):
    prepared, prepare = [], module.Dynamics
    monkeypatch.setattr(module, "Dynamics", lambda *given: prepared.append(given) or prepare(*given))
    rotor = rubbing()
    loaded = replace(rotor, unbalance=np.full(len(rotor.places), 1e-3 + 0j))
    for Omega in (rotor.Omega, 0.9 * rotor.Omega):
        least_trapping_at(loaded, Omega, np.linspace(0.5, 1.0, 3))
        least_trapping_at(loaded, Omega, np.linspace(0.5, 2.0, 3))
    assert len(prepared) == 2


@pytest.mark.parametrize("speeds", [(90.0, 300.0), (300.0, 90.0), (0.0, 120.0)])
def test_traps_are_those_of_the_speed_at_the_end(monkeypatch, speeds):
    class Reached(Exception):
        """The study has chosen its speeds."""

    def stop(highest, *_):
        raise Reached(highest)

    monkeypatch.setattr(contact_traps, "speed_range", stop)
    points = [{"cycle": cycle, "Omega": Omega} for cycle, Omega in zip((1.0, 10.0), speeds, strict=True)]
    scenario = load_scenario(COMPRESSOR).changed(Omega=speeds[0], speed=points, event=[], end_cycle=20)
    with pytest.raises(Reached) as reached:
        studies.traps(scenario)
    assert reached.value.args[0] == pytest.approx(2.0 * speeds[1])
