"""Studies of the thesis's rig, and of what the thesis prints, measures and leaves open."""

from amb_cosim.studies import Study

STUDIES = {
    "thesis_tables": Study(".frequency_tables", "Tables 3.1 to 3.4 of the thesis and the constants of Table 2.2."),
    "tables": Study(".frequency_tables", "Frequencies by mesh, mass matrix and condensation (Tables 3.1 to 3.4)."),
    "reduction": Study(
        ".reduced_models",
        "Full, condensed and coarse model of the rig: frequencies, response, errors (Figs 3.4 to 3.7, Table 3.4).",
    ),
    "coupling_error": Study(
        ".coupling_convergence",
        "Error of the co-simulation of the rig against its monolithic model, over order and communication step.",
    ),
    "contact_laws": Study(
        ".contact_hysteresis", "Force over penetration of the classical contact laws in one blow (Figs 4.1, 4.2)."
    ),
    "synchronous_response": Study(
        ".measured_response",
        "Norm of the synchronous response S(f), computed and measured in co-simulations (Fig. 5.1, 5.18, 5.19).",
    ),
    "test_force": Study(
        ".identification_force",
        "Test force of an identification, its response and how long it takes, over speed (Fig. 5.2).",
    ),
    "h_matrix": Study(
        ".h_interpolation",
        "H of the synchronous control over speed, exact and interpolated; at 10 Hz beside the printed one (Fig. 5.3).",
    ),
    "recovery": Study(
        ".contact_recovery",
        "Share of runs that PID, OLAC, notch, force rejection and ROLAC free of contact, by unbalance (Fig. 5.6).",
    ),
    "readings": Study(
        ".thesis_readings",
        "How near readings of what the thesis leaves open in chapters 4 to 6 come to all that it states.",
    ),
    "rig_unbalance": Study(
        ".unbalance_fit",
        "Unbalances of the rig's discs, fitted to its amplitudes before ROLAC acts (Figs 6.6 to 6.10).",
    ),
}
