"""Studies of the thesis's rig, of the thesis's printed and measured numbers, and of its open points."""

from amb_analysis.studies import Study

STUDIES = {
    "tables": Study(".frequency_tables", "Compute the frequencies of Tables 3.1 to 3.4."),
    "reduction": Study(
        ".reduced_models",
        "Compare full, condensed and coarse rotor models. The study covers Figures 3.4 to 3.7 and Table 3.4.",
    ),
    "coupling_error": Study(".coupling_convergence", "Compare the co-simulation with a monolithic model."),
    "contact_laws": Study(".contact_hysteresis", "Draw the hysteresis of contact laws (Figs 4.1, 4.2)."),
    "synchronous_response": Study(".measured_response", "Compute and measure S(f) (Figs 5.1, 5.18, 5.19)."),
    "test_force": Study(".identification_force", "Compute an identification's test force (Figure 5.2)."),
    "h_matrix": Study(".h_interpolation", "Compare exact and interpolated H (Figure 5.3)."),
    "recovery": Study(".contact_recovery", "Compare controls that free a rubbing rotor. They are those of Figure 5.6."),
}
