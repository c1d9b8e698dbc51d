"""What an axis of the magnetic bearing can do: constants off the centre, range, speed, what it carries."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from amb_actuator.force import pull
from amb_actuator.interface import BANDWIDTH, BIAS, CURRENT_LIMIT, GAP, STATIC
from amb_analysis import design
from amb_cosim.cosim.values import quantity
from amb_cosim.studies import loop_figures
from amb_cosim.studies.outcome import Outcome
from fmi_export.model import Array
from rotor_contact.interface import INTERFACE as PLANT

TOLERANCE = 0.05  # of the linear law
POINTS = 61  # of each side of a map
LOADS = np.linspace(0.0, 1.0 - 1e-6, 61)  # of the largest that the axis can carry; there, more current adds nothing
FREQUENCIES = np.geomspace(1.0, 1e4, 121)  # Hz
SWINGS = (0.25, 0.5, 1.0)  # of the largest sine of the control current


def linearisation(bias_current: str, static_current: str) -> Outcome:
    """K_s and K_i over (x, I_c), where the linear law holds, load capacity, slew rate and bandwidth of one axis."""
    p = design.axis_parameters(
        bias_current=quantity(bias_current, "A", "bias-current"),
        static_current=quantity(static_current, "A", "static-current"),
    )
    largest = float(design.current_amplitude(p, 0.0))
    if not largest > 0.0:
        raise ValueError(
            f"bias-current = {p[BIAS]:g} A with static-current = {p[STATIC]:g} A is not allowed; coils that carry 0 to "
            f"{p[CURRENT_LIMIT]:g} A must be left a control current of both signs"
        )
    k_s, k_i = design.constants(p)
    limits = design.linear_range(p, TOLERANCE)
    data: dict[str, Any] = {
        "bias_current_A": float(p[BIAS]),
        "static_current_A": float(p[STATIC]),
        "k_s_N_per_m": k_s,
        "k_i_N_per_A": k_i,
        "tolerance": TOLERANCE,
        "linear_range": {"x_m": [limits.x_low, limits.x_high], "i_c_A": [limits.i_low, limits.i_high]},
        "slew_rate_N_per_s": list(design.force_slew_rate(p)),
        "amplifier_bandwidth_hz": float(p[BANDWIDTH]),
        "full_swing": [
            {"i_c_A": i, "force_N": float(_amplitude(p, i)), "bandwidth_hz": design.full_swing_bandwidth(p, i)}
            for i in (share * largest for share in SWINGS)
        ],
        "bandwidth": {
            "frequencies_hz": FREQUENCIES.tolist(),
            "force_amplitude_N": _amplitude(p, design.current_amplitude(p, FREQUENCIES)).tolist(),
        },
        "load": _loads(p),
        "map": _map(p),
    }
    return Outcome(data, {"linearisation": partial(loop_figures.linearisation, data)}, as_text(data))


def _amplitude(p: Array, i_c: Array | float) -> Array:
    """Amplitude (N) of the force at the centre under a sine of the control current (A), with saturation."""
    return 0.5 * (design.linearisation(p, 0.0, i_c).force - design.linearisation(p, 0.0, -np.asarray(i_c)).force)


def _loads(p: Array) -> dict[str, Any]:
    """Control force left over static load, and the static load of this axis itself."""

    def carried(static: float) -> float:
        return float(pull(p, p[BIAS] + static, p[GAP]).force - pull(p, p[BIAS], p[GAP]).force)

    own, loads = carried(p[STATIC]), LOADS * carried(p[CURRENT_LIMIT] - p[BIAS])
    capacity, here = design.load_capacity(p, loads), design.load_capacity(p, np.array([own]))
    return {
        "static_load_N": loads.tolist(),
        "static_current_A": capacity.static_current.tolist(),
        "up_N": capacity.up.tolist(),
        "down_N": capacity.down.tolist(),
        "own": {"static_load_N": own, "up_N": float(here.up[0]), "down_N": float(here.down[0])},
    }


def _map(p: Array) -> dict[str, Any]:
    """K_s, K_i and the error of the linear law, rows over I_c and columns over x up to the retainer bearing."""
    clearance = PLANT["rb1.clearance"].start or 0.0
    x, i_c = np.linspace(-clearance, clearance, POINTS), np.linspace(*design.current_range(p), POINTS)
    slopes = design.linearisation(p, x[None, :], i_c[:, None])
    error = design.linear_error(p, x[None, :], i_c[:, None])
    lists = {"x_m": x, "i_c_A": i_c, "k_s": slopes.k_s, "k_i": slopes.k_i, "linear_error": error}
    return {name: values.tolist() for name, values in lists.items()}


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `linearisation` found, to print."""
    title = f"One axis, {data['bias_current_A']:g} A bias and {data['static_current_A']:g} A static current"
    table = Table(title=title, title_justify="left", show_header=False, box=None, padding=(0, 2, 0, 0))
    (x_low, x_high), (i_low, i_high) = (data["linear_range"][key] for key in ("x_m", "i_c_A"))
    (up, down), own = data["slew_rate_N_per_s"], data["load"]["own"]
    table.add_row("K_s, K_i (2.8, 2.9)", f"{1e-3 * data['k_s_N_per_m']:.2f} N/mm, {data['k_i_N_per_A']:.2f} N/A")
    table.add_row(
        f"linear law within {data['tolerance']:.0%}",
        f"x from {1e3 * x_low:.3f} to {1e3 * x_high:.3f} mm, I_c from {i_low:.2f} to {i_high:.2f} A",
    )
    table.add_row("slew rate of the force", f"{1e-6 * up:.3f} MN/s up, {1e-6 * down:.3f} MN/s down")
    swings = (f"{s['i_c_A']:.2f} A ({s['force_N']:.0f} N) to {s['bandwidth_hz']:.0f} Hz" for s in data["full_swing"])
    table.add_row("bandwidth", f"{data['amplifier_bandwidth_hz']:g} Hz; at the voltage limit {', '.join(swings)}")
    table.add_row(
        "control force left",
        f"{own['up_N']:.0f} N up, {own['down_N']:.0f} N down, above a static load of {own['static_load_N']:.0f} N",
    )
    return [table]
