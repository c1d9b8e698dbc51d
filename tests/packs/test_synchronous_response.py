"""Norm of the synchronous response, H beside the printed matrix, response to the test force: the thesis's numbers."""

import json

import numpy as np
import pytest

from amb_analysis.studies.receptance_identification import Identification
from amb_analysis.studies.receptance_measurement import IdentifiedReceptance
from amb_cosim import studies
from bath_thesis.studies import measured_response
from bath_thesis.studies.measured_response import linearised_norm
from bath_thesis.studies.printed_h import printed_h
from rotor_analysis.receptance import receptance


def test_linearised_norm_matches_5_19():
    result = 1e6 * linearised_norm(np.array([0.0, 10.0, 16.0, 29.999, 30.0, 35.0]))
    assert result == pytest.approx([2.0, 4.5, 3.3, 0.5, 0.4, 0.4], abs=1e-3)


def identified(speeds, reason="", **_):
    """What the controller would identify on a loop with continuous control."""
    results = [
        IdentifiedReceptance(w, 1, 45, 50.0, R, 1.01 * R, reason=reason) for w in speeds for R in receptance([w])
    ]
    if reason:
        results = [
            IdentifiedReceptance(w, 1, 45, 50.0, None, R, reason=reason) for w in speeds for R in receptance([w])
        ]
    return Identification(tuple(speeds), tuple(results), None)


def test_measured_norms_are_compared_with_model_and_thesis(monkeypatch, runner, tmp_path):
    monkeypatch.setattr(measured_response, "identify", identified)
    result = runner("study", "synchronous_response", "--at", "10 Hz,35 Hz", "-o", "out")
    assert result.exit_code == 0, result.output
    assert "1.15, 1.09" in result.stdout  # measured over (5.19) at 10 Hz
    at = json.loads((tmp_path / "out" / "synchronous_response.json").read_text())["at_speeds"]
    assert at["spin_frequencies_hz"] == pytest.approx([10.0, 35.0])
    assert at["thesis_m_per_N"] == pytest.approx([4.5e-6, 0.4e-6])
    np.testing.assert_allclose(at["measured_m_per_N"], at["continuous_m_per_N"], rtol=1e-9)
    np.testing.assert_allclose(at["sampled_m_per_N"], 1.01 * np.array(at["measured_m_per_N"]), rtol=1e-9)


def test_norm_is_taken_over_the_columns_of_r(monkeypatch):
    monkeypatch.setattr(measured_response, "identify", identified)
    result = studies.synchronous_response(at="10 Hz")
    R = receptance(2.0 * np.pi * result.spin_frequencies[[40]])[0]
    assert result.norm[40] ** 2 == pytest.approx(np.diag(R.conj().T @ R).real)
    assert result.norm_without_conjugate[40] ** 2 == pytest.approx(np.abs(np.diag(R.T @ R)))
    assert np.all(result.norm_without_conjugate <= result.norm * (1.0 + 1e-12))


def test_failed_identification_is_reported(monkeypatch, refuses):
    monkeypatch.setattr(measured_response, "identify", lambda s, **_: identified(s, "the force reached its limit"))
    message = "the identification at 10 Hz failed: the force reached its limit"
    refuses(message, "study", "synchronous_response", "--at", "10 Hz")


@pytest.mark.slow
def test_controller_measures_the_norm_of_the_sampled_loop():
    at = studies.synchronous_response(at="10 Hz,35 Hz", k_b="0.9e6 N/m").at_speeds
    np.testing.assert_allclose(at.measured, at.sampled, rtol=1e-6)
    np.testing.assert_allclose(at.measured, at.continuous, rtol=0.1)


def test_printed_h_has_its_frobenius_norm():
    assert printed_h().shape == (4, 8)
    assert 1e-6 * np.linalg.norm(printed_h()) == pytest.approx(0.694, abs=5e-4)


def test_h_at_10_hz_is_compared_with_the_printed_one():
    result = studies.h_matrix().at_10_hz
    assert result.frobenius_norm_computed**2 == pytest.approx(np.sum(result.norm_by_force_computed**2))
    assert result.frobenius_norm_printed**2 == pytest.approx(np.sum(result.norm_by_sensor_printed**2))
    R = receptance([2.0 * np.pi * 10.0])[0]
    assert result.computed == pytest.approx(np.abs(np.linalg.pinv(R)))
    assert result.across_computed < 0.01 < 0.5 < result.across_printed


def test_test_force_moves_its_own_journal():
    columns = studies.test_force("50 Hz").at_the_speeds_of_the_thesis
    R = receptance(2.0 * np.pi * columns.frequencies)
    assert columns.response_mb1 == pytest.approx(columns.amplitude * np.abs(R[:, 4, 0]))
    assert columns.response_mb2 == pytest.approx(columns.amplitude * np.abs(R[:, 2, 2]))
    by_frequency = dict(zip(np.round(columns.frequencies), columns.response_mb1, strict=True))
    assert 1e3 * by_frequency[25.0] == pytest.approx(0.02, abs=0.005)
    assert 1e3 * by_frequency[35.0] == pytest.approx(0.24, abs=0.01)
