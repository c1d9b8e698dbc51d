"""The quantities that criteria may limit, and the variables that each adds to those of the machine in formulas."""

from __future__ import annotations

from collections.abc import Mapping

VARIABLES: Mapping[str, tuple[str, ...]] = {
    "axial_frequency": ("frequency", "N"),
    "axial_load": ("capacity",),
    "clearance_share": ("S_cc",),
    "clearance_used": (),
    "clearance_used_fault": (),
    "clearance_used_running": (),
    "cross_coupling_ratio": ("Q_a",),
    "current_demand": (),
    "decrement": ("frequency", "N"),
    "decrement_anticipated": ("frequency", "N"),
    "decrement_anywhere": ("frequency", "N"),
    "decrement_varied": ("frequency", "N"),
    "heat_to_standstill": (),
    "landing_backward_whirl": ("whirl_friction", "friction"),
    "landing_ball_pressure": (),
    "landing_contact_elsewhere": ("whirl_friction", "friction"),
    "landing_failed": ("whirl_friction", "friction"),
    "landing_force": ("weight",),
    "landing_force_change": (),
    "landing_heat": ("weight",),
    "mode_reach": ("frequency",),
    "overload": (),
    "probe_displacement": (),
    "relevitation": (),
    "rest_time": (),
    "retainer_heat": (),
    "retainer_temperature": (),
    "sensitivity_measured": ("frequency",),
    "sensitivity_peak": ("frequency",),
    "sensitivity_peak_beyond": ("frequency",),
    "sensitivity_varied": (),
    "separation_margin": ("AF", "N_c"),
    "slew_demand": (),
    "spectral_radius": ("growth_rate", "frequency", "N"),
    "spectral_radius_varied": ("growth_rate", "frequency", "N"),
    "standstill_time": (),
    "temperature_to_standstill": (),
    "undamped_critical_speed": (),
    "whirl_friction": ("friction",),
}


def check_declared(quantity: str, variables: Mapping[str, float]) -> None:
    """Raise LookupError if an analysis computes a quantity, or gives it variables, that are not in `VARIABLES`."""
    if quantity not in VARIABLES or not variables.keys() <= set(VARIABLES[quantity]):
        raise LookupError(f"{quantity} with {', '.join(variables) or 'no variables'} is not declared in VARIABLES")
