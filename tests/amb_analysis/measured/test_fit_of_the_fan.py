"""`study fit` of the fan of docs/how-to/measured.md; test_response_fit.py judges the fit itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_analysis.measured.response_fit import fit_responses
from amb_cosim import studies
from array_types import Array, Complex
from rotor_analysis.assembly import assemble
from rotor_analysis.rotor_file import load_rotor

PAGE = Path(__file__).parents[3] / "docs/how-to/measured.md"
TRUE, START = np.array([4.2, 0.004]), (4.0, 0.004)  # kg, and a damping ratio
FREE = (FreeParameter("bodies.wheel.mass", 3.0, 6.0), FreeParameter("damping.modal", 0.001, 0.02))
AVERAGES = 10
F = np.linspace(5.0, 1000.0, 200)


def fan(folder: Path) -> Path:
    """Write the rotor file of the page."""
    path = folder / "fan.toml"
    path.write_text(PAGE.read_text().partition("# fan.toml")[2].partition("```")[0])
    return path


class Fan:
    """Accelerations at two places over a force at the wheel of the fan at rest, over mass and damping ratio.

    With the modes of M(m) = M_0 + (m - m_0) dM in a plane, which cost less than the model of the study:

        H = sum phi_out phi_in (-omega^2)/(omega_k^2 - omega^2 + 2j zeta omega_k omega)
    """

    def __init__(self, folder: Path) -> None:
        drawn = load_rotor(fan(folder))
        light = drawn.on_mesh(drawn.shaft.with_nodes_at([0.1]))
        first, second = assemble(light), assemble(replace(light, bodies=(replace(light.bodies[0], mass=5.0),)))
        self.K, self.M, self.change = first.K[::2, ::2], first.M[::2, ::2], (second.M - first.M)[::2, ::2]
        nodes = [light.node_of("wheel"), light.shaft.node_at(0.1)]
        self.rows = [first.translations[node][0] // 2 for node in nodes]

    def responses(self, p: Array) -> list[Complex]:
        squares, shapes = eigh(self.K, self.M + (p[0] - 4.0) * self.change)
        omega_k, omega = np.sqrt(np.maximum(squares, 0.0))[:, None], 2 * np.pi * F
        gains = -(omega**2) / (omega_k**2 - omega**2 + 2j * p[1] * omega_k * omega)
        return [(shapes[row] * shapes[self.rows[0]]) @ gains for row in self.rows]

    def curves(self, p: Array) -> list[FrequencyResponse]:
        force, places = Channel("wheel.f_x", "N"), [Channel(name, "m/s2") for name in ("wheel.x", "0.1 m.x")]
        return [FrequencyResponse(c, force, F, H) for c, H in zip(places, self.responses(p), strict=True)]


def draw(curves: list[FrequencyResponse], seed: int) -> Measurement:
    """Return the responses with noise of a variance v, and the coherence of an estimate of ten averages with it."""
    rng, result = np.random.default_rng(seed), []
    for curve in curves:
        sizes = np.abs(curve.values)
        v = (0.05 * np.median(sizes)) ** 2 + (0.02 * sizes) ** 2
        unit = (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F))) / np.sqrt(2)
        gamma = sizes**2 / (sizes**2 + AVERAGES * v) * (1 + 0.05 * rng.standard_normal(len(F)))
        noisy = curve.values + np.sqrt(v) * unit
        result.append(replace(curve, values=noisy, coherence=np.clip(gamma, 0.01, 1.0)))
    return Measurement(tuple(result))


def test_the_study_fits_what_the_modes_fit(tmp_path):
    model = Fan(tmp_path)
    data = draw(model.curves(TRUE), 3)
    names = [f"{p.name}={p.lowest}:{p.highest}" for p in FREE]
    by_study = studies.fit(fan(tmp_path), measured=data, free=names).fit.parameters
    by_modes, _ = fit_responses(model.responses, data.responses, FREE, START)
    for name, p in by_modes.parameters.items():
        assert by_study[name].value == pytest.approx(p.value, abs=0.02 * (p.upper - p.lower))
        assert by_study[name].upper - by_study[name].lower == pytest.approx(p.upper - p.lower, rel=0.05)
