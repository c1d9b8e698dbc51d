"""Studies of the rotor, its bearings and its control.

Each study is a function that returns a frozen dataclass. `print` shows its tables and `as_dict()` returns its data;
`figure` draws it and `save` writes both, where it has a figure. Arguments are numbers in SI units or texts with a unit,
such as "50 Hz".

    from amb_cosim import studies
    result = studies.campbell(up_to="100 Hz")
    result.critical_speeds[0].speed          # rad/s
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from amb_cosim.studies.figures import figure, save

if TYPE_CHECKING:
    from amb_cosim.studies.bearing_axis import linearisation
    from amb_cosim.studies.campbell_diagram import campbell
    from amb_cosim.studies.contact_convergence import convergence
    from amb_cosim.studies.contact_hysteresis import contact_laws
    from amb_cosim.studies.contact_recovery import recovery
    from amb_cosim.studies.coupling_convergence import coupling
    from amb_cosim.studies.frequency_tables import tables, thesis_tables
    from amb_cosim.studies.h_interpolation import h_matrix
    from amb_cosim.studies.identification_force import test_force
    from amb_cosim.studies.measured_response import synchronous_response
    from amb_cosim.studies.natural_modes import modes, natural_frequencies
    from amb_cosim.studies.receptance_identification import identify
    from amb_cosim.studies.reduced_models import reduction
    from amb_cosim.studies.rotor_layout import layout
    from amb_cosim.studies.run_spectra import waterfall
    from amb_cosim.studies.sensor_receptance import receptance
    from amb_cosim.studies.stability_margin import sensitivity
    from amb_cosim.studies.thesis_readings import readings
    from amb_cosim.studies.unbalance_fit import rig_unbalance
    from amb_cosim.studies.unbalance_over_speed import unbalance_response


class Study(NamedTuple):
    """Module of a study's function, and one line about it."""

    module: str
    description: str


STUDIES = {
    "natural_frequencies": Study(
        "natural_modes", "Damped natural frequencies, damping ratios and whirl directions at some spin speeds."
    ),
    "thesis_tables": Study("frequency_tables", "Tables 3.1 to 3.4 of the thesis and the constants of Table 2.2."),
    "layout": Study("rotor_layout", "Parts, mass and modes of a rotor, the plant's model of it, and a picture."),
    "campbell": Study(
        "campbell_diagram", "Frequencies and damping ratios over speed, critical speeds (Figs 3.1, 3.6)."
    ),
    "modes": Study("natural_modes", "Mode shapes with their orbits (Figs 3.2, 3.3)."),
    "tables": Study("frequency_tables", "Frequencies by mesh, mass matrix and condensation (Tables 3.1 to 3.4)."),
    "reduction": Study(
        "reduced_models",
        "Full, condensed and coarse model of the rig: frequencies, response, errors (Figs 3.4 to 3.7, Table 3.4).",
    ),
    "unbalance_response": Study(
        "unbalance_over_speed", "Amplitude and phase over speed under unbalance at a node (Fig. 3.7)."
    ),
    "contact_laws": Study(
        "contact_hysteresis", "Force over penetration of the classical contact laws in one blow (Figs 4.1, 4.2)."
    ),
    "coupling": Study(
        "coupling_convergence",
        "Convergence of the co-simulation over the communication step, and what the order of the master does to a run.",
    ),
    "convergence": Study(
        "contact_convergence",
        "Peak force, impulse and outcome of a scenario over the modes kept, mesh, substep and perturbed starts.",
    ),
    "sensitivity": Study(
        "stability_margin",
        "Stability margin of the levitated rotor (ISO 14839-3), computed and measured in a co-simulation.",
    ),
    "linearisation": Study(
        "bearing_axis",
        "K_s and K_i off the centre, range of the linear law, load capacity, slew rate and bandwidth of an axis.",
    ),
    "receptance": Study(
        "sensor_receptance", "Synchronous response of the eight sensors to the bearing forces over speed (Fig. 5.1)."
    ),
    "synchronous_response": Study(
        "measured_response",
        "Norm of the synchronous response S(f), computed and measured in co-simulations (Fig. 5.1, 5.18, 5.19).",
    ),
    "test_force": Study(
        "identification_force",
        "Test force of an identification, its response and how long it takes, over speed (Fig. 5.2).",
    ),
    "h_matrix": Study(
        "h_interpolation",
        "H of the synchronous control over speed, exact and interpolated; at 10 Hz beside the printed one (Fig. 5.3).",
    ),
    "recovery": Study(
        "contact_recovery",
        "Share of runs that PID, OLAC, notch, force rejection and ROLAC free of contact, by unbalance (Fig. 5.6).",
    ),
    "waterfall": Study(
        "run_spectra", "Spectra of the orbits of a run, such as a run-up, or of a saved result, over its time."
    ),
    "readings": Study(
        "thesis_readings",
        "How near readings of what the thesis leaves open in chapters 4 to 6 come to all that it states.",
    ),
    "rig_unbalance": Study(
        "unbalance_fit",
        "Unbalances of the rig's discs, fitted to its amplitudes before ROLAC acts (Figs 6.6 to 6.10).",
    ),
    "identify": Study(
        "receptance_identification",
        "Receptances of the levitated rotor, identified by its controller, in a table for later runs.",
    ),
}

__all__ = [
    "STUDIES",
    "Study",
    "campbell",
    "contact_laws",
    "convergence",
    "coupling",
    "figure",
    "h_matrix",
    "identify",
    "layout",
    "linearisation",
    "modes",
    "natural_frequencies",
    "readings",
    "receptance",
    "recovery",
    "reduction",
    "rig_unbalance",
    "save",
    "sensitivity",
    "synchronous_response",
    "tables",
    "test_force",
    "thesis_tables",
    "unbalance_response",
    "waterfall",
]


def __getattr__(name: str) -> Any:
    """Import the function of a study when it is used."""
    if name not in STUDIES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; the studies are {', '.join(STUDIES)}")
    return getattr(import_module(f"{__name__}.{STUDIES[name].module}"), name)


def __dir__() -> list[str]:
    return __all__
