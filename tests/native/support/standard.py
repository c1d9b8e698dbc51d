"""Names of the functions that the standards declare for co-simulation, from their own headers."""

import re
from pathlib import Path

HEADERS = Path(__file__).parents[3] / "libraries" / "fmi_export" / "building" / "native" / "fmi_headers"
DECLARED, MODEL_EXCHANGE, CO_SIMULATION = (
    (HEADERS / "fmi2Functions.h").read_text().split("/* Version number */")[1].split("Functions for FMI2 for ")
)
STANDARD = set(re.findall(r"FMI2_Export \w+ +(\w+);", DECLARED + CO_SIMULATION))
STANDARD3 = set(re.findall(r"FMI3_Export \w+ +(\w+);", (HEADERS / "fmi3Functions.h").read_text()))
