"""The convergence study: the parameters that it varies, its measure of contact, and its verdict on synthetic runs."""

from types import SimpleNamespace

import pytest

from amb_analysis.studies import contact_convergence, convergence_runs
from amb_analysis.studies.convergence_runs import CaseResult, Contact, ConvergenceCase, varied_cases
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from rotor_analysis.reduced_rotor import elastic_shapes, reduced_rotor, with_modes
from rotor_analysis.rotor_file import load_rotor


def base_of(rotor):
    return ConvergenceCase(as_scenario("fig4_9", rotor))


@pytest.fixture
def cases():
    return lambda rotor: list(varied_cases(base_of(rotor)))


SHAPES = {"bath_rig_thesis": [5, 8], "bath_rig": [10, 40], "compressor": [13], "turbo_expander": [11, 25]}


@pytest.mark.parametrize("rotor", SHAPES)
def test_rows_of_modes_state_the_shapes_of_the_reduced_model(cases, rotor):
    """A plane of motion has two rigid shapes; a rotor of few modes has residual shapes of bearings and sites, too.

    Half the modes of the compressor, 2 of 5 shapes, have the same 5 shapes, and are not run.
    """
    varied = [case for case in cases(rotor) if case.varied == "modes"]
    assert [case.value for case in varied] == SHAPES[rotor]
    for case in varied:
        assert case.value == reduced_rotor(load_rotor(case.scenario.rotor)).model.size // 2 - 2
        assert case.label == f"{case.value} shapes"


def test_meshes_differ_only_in_nodes_or_mass_matrix(cases):
    base = load_rotor("bath_rig_thesis")
    result = [(case, load_rotor(case.scenario.rotor)) for case in cases("bath_rig_thesis") if case.varied == "mesh"]
    described = {(len(rotor.shaft.nodes), rotor.shaft.mass_matrix) for _, rotor in result}
    assert len(described) == len(result)
    assert (13, "consistent") in described
    assert (13, "diagonal") not in described
    for case, rotor in result:
        assert case.value == len(rotor.shaft.nodes)
        assert rotor.mass == pytest.approx(base.mass)
        assert rotor.damping == base.damping


@pytest.mark.parametrize("substep", [1e-5, 2.5e-4])
def test_the_row_of_the_scenario_is_its_run(substep):
    """With the substep that it states, longer or shorter than the start value of its rotor."""
    setting = {convergence_runs.SUBSTEP: substep}
    base = ConvergenceCase(as_scenario("fig4_9", None), setting)
    assert convergence_runs.prepare_case(base).parameters == prepare_run(base.scenario, setting).parameters
    halved = next(case for case in varied_cases(base) if case.label == "substep / 2")
    assert convergence_runs.prepare_case(halved).parameters["rotor_contact"]["solver.max_substep"] == substep / 2


@pytest.fixture
def study(monkeypatch):
    """`study(peak, starts, warnings)`: the study with `peak(case)` (N) at RB1 in place of simulations."""

    def run(peak, starts=4, warnings=()):
        def simulated(_, cases, progress):
            progress(len(cases), len(cases))
            sites = [Contact(peak(case), 2.0, 3.0, 4.0) for case in cases]
            return [CaseResult({"rb1": site}, "recovered", 1e-8) for site in sites]

        prepared = SimpleNamespace(warnings=warnings)
        monkeypatch.setattr(contact_convergence, "prepare_case", lambda case: prepared)
        monkeypatch.setattr(contact_convergence, "simulate_in_processes", simulated)
        return studies.convergence("fig4_9", rotor="bath_rig", starts=starts, progress=False)

    return run


@pytest.mark.slow
@pytest.mark.parametrize(("with_all", "verdict"), [(1040.0, "converged: "), (900.0, "not converged: ")])
def test_force_has_converged_if_twice_as_many_modes_change_it_little(study, with_all, verdict):
    result = study(lambda case: with_all if case.label == "40 shapes" else 1000.0)
    assert result.change == pytest.approx(abs(with_all / 10.0 - 100.0))
    assert result.scatter == 0.0
    assert not result.chaotic
    assert verdict in f"\n{result}".splitlines()[-1][: len(verdict)]
    assert "not chaotic" in str(result)


def test_force_that_depends_on_the_communication_step_has_not_converged(study):
    result = study(lambda case: 1900.0 if case.label == "step / 5" else 1000.0)
    assert (result.change, result.step_change) == pytest.approx((0.0, 90.0))
    assert result.averaged_step_change == 0.0
    assert "not converged: with a communication step of 1/5" in str(result).replace("\n", " ")


def test_scattering_starts_are_called_chaotic_and_their_medians_compared(study):
    """Single runs differ by half; the medians over the starts agree within 1 %."""
    peaks = {0: 500.0, 1: 1000.0, 2: 1010.0, 3: 990.0, 4: 1500.0}
    result = study(lambda case: peaks[case.start] + (10.0 if case.label.startswith("40") else 0.0))
    assert result.chaotic
    assert result.scatter == pytest.approx(100.0)
    assert result.change == pytest.approx(1.0)
    assert "chaotic, medians are compared" in str(result)


def test_the_figure_has_forces_in_kn_and_its_legend_beside_the_marks(study):
    figure = studies.figure(study(lambda case: 20e3))
    figure.draw_without_rendering()
    panel = figure.axes[0]
    assert panel.get_ylabel() == "force between impacts (kN)"
    (mark,) = panel.lines[0].get_ydata()
    assert mark == pytest.approx(20.0)
    (legend,) = figure.legends
    assert not any(legend.get_window_extent().overlaps(axes.get_window_extent()) for axes in figure.axes)
    assert all(axes.get_legend() is None for axes in figure.axes)


def test_warnings_of_the_plan_follow_the_verdict(study):
    result = study(lambda case: 1000.0, starts=0, warnings=("a switch is idle",))
    assert result.text()[-1] == "warning: a switch is idle"
    assert result.as_dict()["warnings"] == ["a switch is idle"]


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["fig4_9", "fig4_12", "fig4_14"])
def test_more_modes_leave_contact_forces_of_the_recommended_rig(scenario):
    """A quarter more; twice as many take minutes each, by the study. Forces within a millisecond hang on more modes."""
    settings = {"rotor_contact.contact.impact_law": 1}
    rig = load_rotor("bath_rig")
    rotors = (rig, with_modes(rig, elastic_shapes(rig)[0] * 5 // 4))
    cases = [ConvergenceCase(as_scenario(scenario, rotor), settings) for rotor in rotors]
    here, more = (convergence_runs.simulate_case(case).sites for case in cases)
    for site, contact in here.items():
        assert more[site].mean_force == pytest.approx(contact.mean_force, rel=0.05)
