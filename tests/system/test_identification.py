"""The receptance that the controller FMU identifies on the plant FMU, compared with models of the loop; and its use."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.slow

FREQUENCIES = (10.0, 16.0, 35.0)  # Hz
RIG = "rolac_controller.chain.preset=1"


def identified(frequencies: list[float], settings: list[str], rotor: str | None = None) -> list[dict[str, Any]]:
    """Return deviations of the identified R from two models, computed in a separate process."""
    import math

    import numpy as np

    from amb_analysis.studies import receptance_measurement
    from amb_cosim.commands.options import parse_settings
    from rotor_analysis.receptance import receptance

    def deviation(ratios: np.ndarray) -> list[float]:
        return [float(np.abs(np.abs(ratios) - 1.0).max()), float(np.degrees(np.abs(np.angle(ratios))).max())]

    matches = []
    for frequency in frequencies:
        values = parse_settings(settings)
        prepared = receptance_measurement.prepare_identification(2.0 * math.pi * frequency, rotor, values)
        result = receptance_measurement.run_identification(prepared)
        assert result.receptance is not None, result.reason
        continuous = receptance(np.array([result.speed]))[0]
        matches.append(
            {
                "sampled": deviation(receptance_measurement.ratios(result.receptance, result.model)),
                "continuous": deviation(receptance_measurement.ratios(result.receptance, continuous)),
                "compared": len(receptance_measurement.ratios(result.receptance, result.model)),
            }
        )
    return matches


@pytest.fixture(scope="module")
def identify(run_once: Callable[..., Any]) -> Callable[..., list[dict[str, Any]]]:
    return lambda frequencies, *settings, **more: run_once(
        identified, timeout=300, frequencies=frequencies, settings=settings, **more
    )


# Settings, and largest deviation in size and phase (deg) from the model of the sampled loop.
CHAINS: dict[str, tuple[list[str], tuple[float, float]]] = {"ideal": ([], (1e-7, 1e-5)), "rig": ([RIG], (0.01, 1.0))}


@pytest.mark.parametrize("chain", CHAINS)
def test_identified_receptance_is_that_of_the_sampled_loop(identify: Any, regression: Any, chain: str) -> None:
    """The deviation from the continuous model, in size and phase (deg), is the error of a table made from that."""
    settings, sampled = CHAINS[chain]
    for frequency, result in zip(FREQUENCIES, identify(FREQUENCIES, *settings), strict=True):
        assert result["compared"] >= 16
        assert np.all(np.array(result["sampled"]) < sampled)
        regression(f"deviation from the continuous model at {frequency:g} Hz", result["continuous"], rel=0.25)


CASES = {
    "bearings weaker than the controller takes them to be": [
        "amb_actuator.*.k_i_measured_?=520",
        "amb_actuator.*.k_s_measured_?=1.9e6",
    ],
    "sampled every other step": ["rolac_controller.sample_time=500 us", "rolac_controller.*.c_b_?=3000"],
    "one sample late": ["rolac_controller.chain.preset=2", "rolac_controller.chain.delay=true"],
    "filtered derivative, integral, an unbalance on the rotor": [
        "rolac_controller.derivative_time=200 us",
        "rolac_controller.*.k_integral_?=1e6",
        "rotor_contact.d1.u=4 g.m",
    ],
    "the second harmonic": ["rolac_controller.harmonic1.order=2"],
}


@pytest.mark.parametrize("case", CASES)
def test_identification_agrees_with_the_model_of_every_loop(identify: Any, case: str) -> None:
    (result,) = identify([16.0], *CASES[case])
    assert np.all(np.array(result["sampled"]) < (1e-6, 1e-4))


def test_identification_agrees_with_the_model_with_amplifiers(identify: Any) -> None:
    """Their mean current over a step couples them to the rotor with second order."""
    (result,) = identify([16.0], "amb_actuator.amplifier=1", "amb_actuator.mean_current=true")
    assert np.all(np.array(result["sampled"]) < (1e-3, 0.1))


def test_another_rotor_has_another_receptance(identify: Any, tmp_path: Any) -> None:
    from rotor_analysis.packaged_rotors import rotor_path

    heavy = tmp_path / "heavy.toml"
    heavy.write_text(rotor_path().read_text(encoding="utf-8").replace("mass = 10.0", "mass = 13.0"), encoding="utf-8")
    (result,) = identify([16.0], rotor=str(heavy))
    assert np.all(np.array(result["sampled"]) < (1e-7, 1e-5))
    assert result["continuous"][0] > 0.15


def used() -> dict[str, Any]:
    """ROLAC with H of the model and of a table from the same loop: a recovery at 16 Hz, and a free orbit."""
    import math
    from pathlib import Path

    import numpy as np

    from amb_analysis.studies import receptance_measurement
    from amb_cosim.results.summary import summarise
    from amb_cosim.scenario.prepare_run import prepare_run
    from amb_cosim.scenario.scenario import load_scenario, make_scenario
    from amb_cosim.scenario.simulation import execute

    table = Path("table.toml").absolute()
    prepared = receptance_measurement.prepare_identification(2.0 * math.pi * 16.0)
    result = receptance_measurement.run_identification(prepared)
    receptance_measurement.table_for(prepared, table).updated(result.speed, result.receptance).write(table)

    recovery = load_scenario("fig5_6")
    free = make_scenario(
        {
            "description": "free",
            "Omega": "16 Hz",
            "end_cycle": 100,
            "inputs": {"rotor_contact": {"d1.u": "3 g.m"}, "rolac_controller": {"rolac_enable": False}},
            "event": [{"cycle": 1, "set": {"rolac_controller": {"rolac_enable": True}}}],
            "record": {"variables": ["rolac_controller.*s?"]},
        },
        "free",
    )
    answers: dict[str, Any] = {}
    for source, receptances in (("model", None), ("table", str(table))):
        values = {"receptances": receptances}
        settings = {"rolac_controller.rolac.alpha": "5 1/s"}
        recovered = execute(prepare_run(recovery.model_copy(update=values), settings))
        d = execute(prepare_run(free.model_copy(update=values), settings)).dataset
        q = np.array(
            [
                d[f"rolac_controller.amplitude.s{k}"].values * np.exp(1j * d[f"rolac_controller.phase.s{k}"].values)
                for k in range(1, 9)
            ]
        )
        before, after = q[:, np.searchsorted(d["cycle"], 0.9)], q[:, -1]
        force = np.linalg.lstsq(result.receptance, -before, rcond=None)[0]
        least = np.linalg.norm(before + result.receptance @ force)
        summary = summarise(recovered.dataset).as_dict()
        answers[source] = {
            "recovery": {key: summary[key] for key in ("recovered", "last_contact_cycle")},
            "of_optimum": float(np.linalg.norm(after) / least),
            "of_before": float(np.linalg.norm(after) / np.linalg.norm(before)),
        }
    return answers


@pytest.fixture(scope="module")
def in_use(run_once: Callable[..., Any]) -> dict[str, Any]:
    return run_once(used, timeout=300)


def test_rolac_recovers_with_the_identified_h_as_with_that_of_the_model(in_use: Any) -> None:
    model, table = (in_use[source]["recovery"] for source in ("model", "table"))
    assert model["recovered"]
    assert table["recovered"]
    assert table["last_contact_cycle"] == pytest.approx(model["last_contact_cycle"], abs=0.5)


def test_rolac_attenuates_to_the_least_squares_optimum_with_either(in_use: Any) -> None:
    """The identified H is exact where it was identified; the model's is off by some percent."""
    assert in_use["table"]["of_optimum"] == pytest.approx(1.0, abs=1e-4)
    assert in_use["model"]["of_optimum"] == pytest.approx(1.0, abs=0.01)
    for source in ("model", "table"):
        assert in_use[source]["of_before"] < 0.6
