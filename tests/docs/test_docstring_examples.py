"""Examples in docstrings run, and print what they say."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest

EXAMPLES = (
    "amb_cosim.assessment.assess.assess",
    "amb_cosim.controllers.linear_controller.linear_controller",
    "amb_cosim.cosim.run.simulate.simulate",
    "amb_cosim.cosim.system.system.System",
    "amb_cosim.cosim.system.system_file.load_system",
    "amb_cosim.cosim.verify.verification.verify",
    "amb_cosim.export.assembled.build_assembled",
    "amb_cosim.export.build.build",
    "amb_cosim.export.exchange.export_ssp",
    "amb_cosim.linear.linearise.linearise",
    "amb_cosim.presentation.units.convert_units_in_text",
    "amb_cosim.presentation.units.units",
    "amb_cosim.results.result.Result",
    "amb_cosim.scenario.scenario.Scenario",
    "amb_cosim.scenario.scenario.scenarios",
    "amb_cosim.scenario.simulation.check",
    "amb_cosim.studies.Study",
    "amb_cosim.studies.bearing_axis.linearisation",
    "amb_cosim.studies.campbell_diagram.campbell",
    "amb_cosim.studies.closed_loop_poles.poles",
    "amb_cosim.studies.figures.figure",
    "amb_cosim.studies.figures.save",
    "amb_cosim.studies.frequency_responses.response",
    "amb_cosim.studies.natural_modes.modes",
    "amb_cosim.studies.receptance_identification.identify",
    "amb_cosim.studies.rotor_layout.layout",
    "amb_cosim.studies.run_spectra.waterfall",
    "amb_cosim.studies.sensor_receptance.receptance",
    "amb_cosim.studies.stability_margin.sensitivity",
    "amb_cosim.studies.unbalance_over_speed.unbalance_response",
    "amb_files.suggestions.suggest",
    "amb_files.wildcards.matching_names",
    "fmi_export.building.units.base_unit",
    "fmi_export.building.units.to_unit",
    "rotor_analysis.rotor.Rotor",
    "rotor_analysis.undamped.natural_frequencies",
)


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_prints_what_it_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module_name, _, function = name.rpartition(".")
    module = import_module(module_name)
    tests = doctest.DocTestFinder(recurse=False).find(getattr(module, function), function, module)
    assert sum(len(test.examples) for test in tests) > 0
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    said: list[str] = []
    for test in tests:
        runner.run(test, out=said.append)
    assert runner.failures == 0, "".join(said)
