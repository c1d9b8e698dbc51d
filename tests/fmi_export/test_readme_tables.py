"""Every model's README holds the table of its interface, word for word."""

import importlib
from pathlib import Path

import pytest

from amb_cosim import models
from fmi_export.building.readme import BEGIN, END, interface_table


@pytest.mark.parametrize("name", models.MODELS)
def test_the_readme_contains_exactly_the_interface_table(name):
    model, _ = getattr(models, name)()
    readme = Path(importlib.import_module(name).__file__).parent / "README.md"
    shown = readme.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    command = f"python -m fmi_export.building.readme amb_cosim.models:{name} fmus/{name}/README.md"
    assert shown.strip() == interface_table(model), f"regenerate with: {command}"
