"""Formulas of an assessment by hand, from the numbers of its JSON, which contains the machine's file."""

import re

import numpy as np
import pytest

from amb_assessment.assessment.engine.assess import assess

pytestmark = pytest.mark.slow
RPM, MU_0, G = np.pi / 30.0, 4e-7 * np.pi, 9.81
PRINTED = 1e-3  # of a number with four digits
LEVELS, MAGNET = (6.5, 5.0), {"N": 48.0, "A": 4.5e-3, "gap": 0.5e-3, "half": np.pi / 8.0}  # of the packaged compressor


@pytest.fixture(scope="module")
def compressor():
    return assess("compressor", only=["cross_coupling", "unbalance", "envelope"]).as_dict()


@pytest.fixture(scope="module")
def pump():
    return assess("turbo_pump", only=["axial"]).as_dict()


def findings(data, quantity):
    return [found for part in data["parts"].values() for found in part["findings"] if found["quantity"] == quantity]


def table(data, title):
    (found,) = (t for part in data["parts"].values() for t in part["tables"] if t["title"] == title)
    return [dict(zip(found["heads"], row, strict=True)) for row in found["rows"]]


def size(text):
    """The number that a text of the machine's file begins with."""
    return float(text.split()[0])


def test_separation_margins_and_what_their_amplification_requires(compressor):
    low, high = compressor["facts"]["N_min"], compressor["facts"]["N_mc"]
    margins = findings(compressor, "separation_margin")
    assert len(margins) >= 3
    for found in margins:
        N, AF = found["facts"]["N_c"], found["facts"]["AF"]
        expected = (low - N) / low if low > N else (N - high) / high
        assert found["value"] == pytest.approx(100.0 * expected, rel=1e-12)
        if found.get("limit") is not None:
            required = 17.0 * (1.0 - 1.0 / (AF - 1.5))
            assert AF >= 2.5
            assert found["limit"] == pytest.approx(min(16.0, required) if low > N else min(26.0, 10.0 + required))


def test_unbalance_of_a_mode_is_twice_the_residual_unbalance(compressor):
    """U = 2 * 6350 W/N (g mm), the weight in kg."""
    whole = 2.0 * 6350.0 * compressor["facts"]["mass"] / compressor["facts"]["N_mc"]
    for row in table(compressor, "Unbalance of each mode"):
        amounts = re.findall(r"([\d.]+) g mm", row["unbalance, with its sign"])
        assert sum(map(float, amounts)) == pytest.approx(whole, rel=5e-3)


def test_probe_limit_and_the_scale_of_clearances(compressor):
    """A_vl = 25.4 um sqrt(12000/N), at most 25.4 um; S_cc = A_vl/A_max of the same unbalance, from 1 to 6."""
    limit = 25.4 * min(1.0, np.sqrt(12000.0 / compressor["facts"]["N_mc"]))
    probes = {re.search("mode .*", f["where"])[0]: f for f in findings(compressor, "probe_displacement")}
    shares = findings(compressor, "clearance_share")
    assert len(probes) == 3
    assert shares
    for found in shares:
        probe = probes[re.search("mode .*", found["where"])[0]]
        assert probe["limit"] == pytest.approx(limit, rel=1e-12)
        assert found["facts"]["S_cc"] == pytest.approx(np.clip(limit / probe["value"], 1.0, 6.0), rel=1e-9)


def test_anticipated_cross_coupling_of_the_stages(compressor):
    """Q = 3 T r/(D b) with the torque T = P/Omega and the ratio r of the densities; level I counts their sum."""
    Omega, stages = compressor["facts"]["N_mc"] * RPM, compressor["machine"]["stages"]
    Q = [
        3.0 * 1e3 * size(s["power"]) / Omega * s["density_ratio"] / (size(s["diameter"]) * 1e-3 * size(s["width"]))
        for s in stages
    ]
    given = [float(row["anticipated (MN/m)"]) for row in table(compressor, "Cross-coupled stiffness")]
    assert given == pytest.approx(np.array(Q) / 1e6, rel=PRINTED)
    (ratio,) = findings(compressor, "cross_coupling_ratio")
    assert ratio["facts"]["Q_a"] == pytest.approx(sum(Q), rel=1e-4)


def demands(data):
    """Force (N), speed (rad/s), current and its limit, voltage and its limit, slew rate and its limit, by axis."""
    for row in table(data, "Largest demands"):
        pairs = [map(float, row[name].split(" of ")) for name in ("current (A)", "voltage (V)", "slew rate (N/s)")]
        yield row["axis"], float(row["force (N)"]), float(row["at (rpm)"]) * RPM, *(tuple(pair) for pair in pairs)


def value_at(data, quantity, axis):
    return max(found["value"] for found in findings(data, quantity) if found["where"].startswith(axis))


def test_current_and_voltage_of_the_unbalance(compressor):
    """I <= I_max - I_s - I_b and I_b; the voltage is R I_0 + I |R + j Omega L|."""
    R, L, V = 0.2, 52e-3, 900.0
    for axis, _, Omega, (current, most), (voltage, limit), _ in demands(compressor):
        assert most == pytest.approx(min(11.5 - LEVELS[0], LEVELS[1]), rel=PRINTED)
        assert limit == V
        assert voltage == pytest.approx(R * LEVELS[0] + current * abs(R + 1j * Omega * L), rel=2.0 * PRINTED)
        assert value_at(compressor, "current_demand", axis) == pytest.approx(100.0 * current / most, rel=2.0 * PRINTED)


def test_slew_rate_of_the_force(compressor):
    """F Omega, over K_i V/L with K_i = 2 mu_0 N^2 A cos(phi)/l^2 (I_s + 2 I_b)."""
    m = MAGNET
    K_i = 2.0 * MU_0 * m["N"] ** 2 * m["A"] * np.cos(m["half"]) / m["gap"] ** 2 * sum(LEVELS)
    for axis, force, Omega, _, _, (slew, limit) in demands(compressor):
        assert slew == pytest.approx(force * Omega, rel=2.0 * PRINTED)
        assert limit == pytest.approx(K_i * 900.0 / 52e-3, rel=PRINTED)
        assert value_at(compressor, "slew_demand", axis) == pytest.approx(100.0 * slew / limit, rel=2.0 * PRINTED)


def test_load_and_capacity_of_a_thrust_bearing(pump):
    """Weight and thrust over mu_0 N^2 A/(4 g^2) (2 I_b)^2, where one coil has lost its bias."""
    bearing = pump["machine"]["thrust_bearing"]
    area, gap = 1e-4 * size(bearing["pole_area"]), 1e-3 * size(bearing["gap"])
    capacity = MU_0 * bearing["turns"] ** 2 * area / (4.0 * gap**2) * (2.0 * size(bearing["bias_current"])) ** 2
    load = G * pump["facts"]["mass"] + max(-size(thrust) for thrust in bearing["thrust"])
    for found in findings(pump, "axial_load"):
        assert found["facts"]["capacity"] == pytest.approx(capacity, rel=1e-6)
        assert found["value"] == pytest.approx(100.0 * load / capacity, rel=1e-6)


def test_a_pole_is_the_growth_over_a_sample(pump):
    """|z| = exp(sigma h)."""
    (found,) = findings(pump, "spectral_radius")
    assert found["value"] == pytest.approx(np.exp(found["facts"]["growth_rate"] * 50e-6), rel=1e-12)


def test_decrement_and_damping_ratio_belong_together(pump):
    """2 pi zeta/sqrt(1 - zeta^2); the finding has the smallest of the table."""
    rows = table(pump, "The axial loop under the static forces that it carries")
    for row in rows:
        zeta = float(row["damping ratio"])
        decrement = 2.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2)
        assert float(row["decrement"]) == pytest.approx(decrement, rel=3e-3)
    (found,) = findings(pump, "decrement_anywhere")
    assert found["value"] == pytest.approx(min(float(row["decrement"]) for row in rows), rel=PRINTED)
