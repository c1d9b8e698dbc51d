"""Every model's README holds the table of its interface, word for word."""

import importlib
from pathlib import Path

import pytest

from fmi_export.building.readme import BEGIN, END, interface_table

MODULES = ["amb_actuator.actuator", "rolac_controller.controller", "rotor_contact.plant"]


@pytest.mark.parametrize("module", MODULES)
def test_the_readme_contains_exactly_the_interface_table(module):
    loaded = importlib.import_module(module)
    readme = Path(loaded.__file__).parent / "README.md"
    shown = readme.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    command = f"python -m fmi_export.building.readme {module} {readme.parent.name}/README.md"
    assert shown.strip() == interface_table(loaded.MODEL), f"regenerate with: {command}"
