"""Examples in docstrings run, and print what they say."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest

EXAMPLES = (
    "amb_assessment.assessment.assess.assess",
    "amb_cosim.controllers.linear_controller.linear_controller",
    "amb_cosim.cosim.run.simulate.simulate",
    "amb_cosim.cosim.system.system.System",
    "amb_cosim.cosim.system.system_file.load_system",
    "amb_cosim.cosim.verify.verification.verify",
    "amb_cosim.export.assembled.build_assembled",
    "amb_cosim.export.build.build",
    "amb_cosim.export.exchange.export_ssp",
    "amb_analysis.linear.linearise.linearise",
    "amb_cosim.presentation.units.convert_units_in_text",
    "amb_cosim.presentation.units.units",
    "amb_cosim.results.result.Result",
    "amb_cosim.scenario.scenario.Scenario",
    "amb_cosim.scenario.scenario.scenarios",
    "amb_cosim.scenario.simulation.check",
    "amb_analysis.studies.Study",
    "amb_analysis.studies.bearing_axis.linearisation",
    "amb_analysis.studies.campbell_diagram.campbell",
    "amb_analysis.studies.closed_loop_poles.poles",
    "amb_analysis.studies.figures.figure",
    "amb_analysis.studies.figures.save",
    "amb_analysis.studies.frequency_responses.response",
    "amb_analysis.studies.natural_modes.modes",
    "amb_analysis.studies.receptance_identification.identify",
    "amb_analysis.studies.rotor_layout.layout",
    "amb_analysis.studies.run_spectra.waterfall",
    "amb_analysis.studies.sensor_receptance.receptance",
    "amb_analysis.studies.stability_margin.sensitivity",
    "amb_analysis.studies.unbalance_over_speed.unbalance_response",
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
