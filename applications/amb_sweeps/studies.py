"""The study of robustness, which this package provides."""

from amb_analysis.studies import Study

STUDIES = {
    "robustness": Study(
        "amb_sweeps.robustness",
        "Check whether an outcome is robust. H is identified, and parameters change by 1 %.",
    ),
}
