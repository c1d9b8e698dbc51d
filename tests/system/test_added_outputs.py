"""Outputs added to the FMUs in a copy, an energy among them: at most three files each, all in one package."""

from __future__ import annotations

from collections import ChainMap

import pytest
from changed_copy import ROOT, change, importing

POWER = {
    "interface.py": (
        (
            '        declare("copper_loss", "W"',
            '        declare("power", "W", "Electric power, {}", **by_current),\n        declare("copper_loss", "W"',
        ),
    ),
    "actuator.py": (
        (
            "    y.copper_loss =",
            "    y.power = y.upper_voltage * upper_current + y.lower_voltage * lower_current\n    y.copper_loss =",
        ),
    ),
}
SAMPLES = {
    "signals.py": (
        (
            '        _number("table_rows"',
            '        _later("samples", "1", "Samples so far", ()),\n        _number("table_rows"',
        ),
    ),
    "outputs.py": (
        (
            "    common.table_rows = table.n_rows[0]\n",
            "    common.table_rows = table.n_rows[0]\n    common.samples = state.head[0].n_samples\n",
        ),
    ),
}
LARGEST_FRICTION = {
    "site_variables.py": (
        (
            '        output(\n            f"{site}.f_n_mean"',
            '        output(f"{site}.f_t_peak", "N", f"Largest friction {at}", initially_depends_on=forces),\n'
            '        output(\n            f"{site}.f_n_mean"',
        ),
    ),
    "over_step.py": (
        ('    ("f_n_mean", np.float64)', '    ("f_t_peak", np.float64),\n    ("f_n_mean", np.float64)'),
        ('("f_n", np.float64))', '("f_n", np.float64), ("f_t", np.float64))'),
        ("= site.f_n_peak = site.f_n_mean = 0.0", "= site.f_n_peak = site.f_t_peak = site.f_n_mean = 0.0"),
        (
            "    rate.heat = heat\n",
            "    rate.heat = heat\n    rate.f_t = abs(site.f_t) if site.mode != FREE else 0.0\n",
        ),
        (
            "begin.f_n, 0.5 * (second.f_n + third.f_n), end.f_n))\n",
            "begin.f_n, 0.5 * (second.f_n + third.f_n), end.f_n))\n"
            "    site.f_t_peak = max(site.f_t_peak, greatest_of_parabola(begin.f_t, 0.5 * (second.f_t + third.f_t), "
            "end.f_t))\n",
        ),
        (
            "greatest_of_cubic(a.f_n, b.f_n, c.f_n, d.f_n))\n",
            "greatest_of_cubic(a.f_n, b.f_n, c.f_n, d.f_n))\n"
            "    at_nodes = greatest_of_cubic(abs(a.f_t), abs(b.f_t), abs(c.f_t), abs(d.f_t))\n"
            "    site.f_t_peak = max(site.f_t_peak, at_nodes)\n",
        ),
        ("    site.f_n_peak = 0.0\n", "    site.f_n_peak = site.f_t_peak = 0.0\n"),
    ),
    "outputs.py": (("    y.f_n_mean =", "    y.f_t_peak = site.f_t_peak\n    y.f_n_mean ="),),
}
HEAT_OF_SEALS = {
    "energies.py": (
        ('("work", np.float64)\n', '("work", np.float64), ("seal_heat", np.float64)\n'),
        (
            '        output(\n            "energy.impact"',
            '        output("energy.seals", "J", "Heat of seals so far", initially_depends_on=()),\n'
            '        output(\n            "energy.impact"',
        ),
        ("    energy.impact =", "    energy.seals = integrals.seal_heat\n    energy.impact ="),
    ),
    "integration.py": (("    rates.work = work\n", "    rates.work = work\n    rates.seal_heat = heat_in_seals\n"),),
    "piece_energy.py": (
        (
            "        damping += h * mean_heat(before, after, h)\n",
            "        damping += h * mean_heat(before, after, h)\n"
            "        integrals.seal_heat += h * mean_heat(before, after, h)\n",
        ),
        (
            "        heat, power = _shaft_heat_and_power(w, propagator.end)\n",
            "        heat, power, in_seals = _shaft_heat_and_power(w, propagator.end)\n"
            "        integrals.seal_heat += h * in_seals\n",
        ),
        ("-> tuple[float, float]:", "-> tuple[float, float, float]:"),
        ("    heat = power = 0.0\n", "    heat = power = in_seals = 0.0\n"),
        (
            "        power -= GAUSS_WEIGHTS[k]",
            "        in_seals += GAUSS_WEIGHTS[k] * heat_in_seals\n        power -= GAUSS_WEIGHTS[k]",
        ),
        ("    return heat, power\n", "    return heat, power, in_seals\n"),
    ),
}
ADDED = {"amb_actuator": (POWER,), "rolac_controller": (SAMPLES,), "rotor_contact": (LARGEST_FRICTION, HEAT_OF_SEALS)}


def stepped():
    """Return the added outputs after steps of the three models, and what they must agree with."""
    from dataclasses import replace

    import numpy as np
    from rotor_cases import H, both, place, plant, rigid_rotor, run

    from amb_cosim.export.models import amb_actuator, rolac_controller
    from fmi_export.model import Instance
    from rotor_analysis.parts import Bearing

    actuator, controller = Instance(*amb_actuator()), Instance(*rolac_controller())
    actuator["amplifier"], actuator["mb1.i_x"] = 1.0, 0.5
    actuator.initialise()
    controller.initialise()
    for k in range(3):
        controller.step(k * controller["sample_time"], controller["sample_time"])
    sliding = {}
    for exact in (0.0, 1.0):
        values = both("rb.clearance", 0.05) | both("rb.mu", 0.1) | {"Omega": 36.0, "solver.energy_limit": 1e9}
        x = plant(values | {"solver.exact_motion": exact}, rigid_rotor())
        place(x, np.full(2, 0.05 + 0j), np.full(2, 1j), modes=(1, 1))
        record = run(x, 35, ["rb1.f_t", "rb1.f_t_peak"])
        sliding[f"exact_motion {exact:g}"] = [abs(float(record[-2, 0])), float(record[-1, 1])]
    seal = Bearing("ring", 1, ((3e5, 0.0), (0.0, 3e5)), ((400.0, 0.0), (0.0, 400.0)))
    heat = []
    for exact, Omega_dot in ((0.0, 0.0), (1.0, 0.0), (1.0, 50.0)):
        values = both("mb.k_b", 2e6) | {"Omega": 200.0, "Omega_dot": Omega_dot, "d1.u": 1e-4}
        x = plant(values | {"solver.exact_motion": exact}, replace(rigid_rotor(), seals=(seal,)))
        for k in range(80):
            x["Omega"] = 200.0 + Omega_dot * k * H
            x.step(k * H, H)
        heat.append([x["solver.method"], x["energy.seals"], x["energy.damping"]])
    return {
        "heat": heat,
        "power": [actuator["mb1.power_x"], actuator["mb1.copper_loss_x"]],
        "samples": controller["samples"],
        "sliding": sliding,
    }


@pytest.fixture(scope="module")
def outputs(tmp_path_factory, run_python):
    folder = tmp_path_factory.mktemp("copy")
    for package, added in ADDED.items():
        assert all(len(files) <= 3 for files in added)
        change(folder, ROOT / "fmus" / package, dict(ChainMap(*added)))
    return importing(folder, run_python)(stepped)


def test_steady_coils_take_the_power_that_their_copper_loses(outputs):
    """v i = R i^2."""
    power, copper_loss = outputs["power"]
    assert power == pytest.approx(copper_loss, rel=1e-12)
    assert power > 0.0


def test_samples_are_counted(outputs):
    assert outputs["samples"] == 3.0


def test_largest_friction_of_a_whirl_that_slows_down_is_that_at_the_begin_of_the_step(outputs):
    """N = m v^2/c falls with v, and T = mu N."""
    for before, largest in outputs["sliding"].values():
        assert largest == pytest.approx(before, rel=1e-6)


def test_heat_of_seals_is_that_of_all_damping_where_nothing_else_damps(outputs):
    """By substeps, by exact motion at constant speed, and by pieces at a speed that rises."""
    methods, in_seals, damping = zip(*outputs["heat"], strict=True)
    assert len(set(methods)) == 3
    assert in_seals == pytest.approx(damping, rel=1e-9)
    assert min(damping) > 1e-6
