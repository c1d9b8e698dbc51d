"""Units that a user chooses act on every table and sentence of every study and assessment.

The studies come from the registry.
"""

import html
import math
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text

import rotor_literature
from amb_analysis.measured.records import Measurement, Modes
from amb_analysis.studies.controller_description import describe_controller
from amb_analysis.studies.result import DrawnResult
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.page.page import page
from amb_cosim import studies
from amb_cosim.presentation.text_tables import rendered
from amb_cosim.presentation.units import QUANTITIES, SIZES, units
from amb_cosim.scenario.scenario import load_scenario

MACHINE = "compressor_levitated"
RUN = load_scenario(MACHINE).changed(settle_cycles=0, end_cycle=0.5)
BLOWER = Path(__file__).parents[1] / "amb_assessment" / "assessment" / "blower" / "machine.toml"
EXPANDER = Path(__file__).parents[1] / "strange_machine" / "expander.toml"
MODES = Measurement(modes=Modes(np.array([595.0, 1315.0]), np.full(2, np.nan)))
ARGUMENTS = {  # of every study; a study that is not here fails
    "layout": {"rotor": "compressor"},
    "campbell": {"rotor": "compressor", "speed": "9000 rpm"},
    "modes": {"rotor": "compressor", "speeds": "9000 rpm", "count": 2},
    "unbalance_response": {"rotor": "compressor", "up_to": "6000 rpm"},
    "coupling": {"scenario": RUN},
    "convergence": {"scenario": "drop", "starts": 2},
    "sensitivity": {"scenario": MACHINE},
    "poles": {"scenario": MACHINE, "up_to": "9000 rpm", "count": 2},
    "traps": {"scenario": MACHINE, "unbalance": "30 g.m"},
    "linearisation": {"scenario": MACHINE},
    "receptance": {"rotor": "compressor"},
    "response": {"scenario": MACHINE, "inputs": ["impeller3.f_x"], "outputs": ["seal.x"], "up_to": "100 Hz"},
    "fit": {"rotor": EXPANDER, "measured": MODES, "free": {"materials.steel.youngs_modulus": (1.8e11, 2.4e11)}},
    "waterfall": {"source": RUN.changed(end_cycle=1), "window": "6 ms"},
    "identify": {"speeds": "9000 rpm", "scenario": MACHINE, "computed": True},
    "robustness": {"scenario": RUN},
    "tables": {},
    "reduction": {"up_to": "20 rad/s"},
    "coupling_error": {},
    "contact_laws": {},
    "synchronous_response": {"at": "10 Hz", "up_to": "10 Hz"},
    "test_force": {},
    "h_matrix": {},
    "recovery": {"steps": "20 g.m", "instants": 1, "alpha": "7 1/s"},
}
SLOW = {
    "convergence", "coupling", "coupling_error", "fit", "recovery", "reduction", "sensitivity", "synchronous_response",
    "traps",
}  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])-?(?:\d{1,3}(?:,\d{3})+|\d+)\.?\d*(?:e[-+]?\d+)?")
NAMES = "|".join(map(re.escape, (*QUANTITIES, "1/min", "\N{MICRO SIGN}m")))
UNIT = re.compile(rf"(?:\d |\()({NAMES})(?=[,;:.)]|\s(?!s/m|m/|s\))|$)")
PLACES = re.compile(r"(?:[rz]|at|position)\$? \(m?m\)|z = \S+ m?m\b")  # places along the shaft keep their unit
SYMBOLS = re.compile(r"\$[^$]*\$")
BEFORE, AFTER = ("rpm", "mm", "N"), ("Hz", "um", "kN")
FACTORS = [SIZES[QUANTITIES[a]][a] / SIZES[QUANTITIES[b]][b] for a, b in zip(BEFORE, AFTER, strict=True)]


def shown(result, *chosen):
    with units(*chosen):
        return PLACES.sub("", rendered(result.text()))


def text_of_page(assessment, *chosen):
    with units(*chosen):
        body = page(assessment).partition("<main>")[2].partition("</main>")[0]
    text = " ".join(html.unescape(re.sub(r"<[^>]*>", " ", body)).split())
    return PLACES.sub("", re.sub(r", \d+\.\d s ", " ", text))  # without times of computation


def drawn(result, *chosen):
    """Return the texts of a study's figure, and the label and limits of each of its axes."""
    with units(*chosen):
        figure = studies.figure(result)
        ends = [
            (axis.get_label_text(), np.sort(axis.get_view_interval()))
            for axes in figure.axes
            for axis in (axes.xaxis, axes.yaxis)
        ]
    ticks = {text for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for text in axis.findobj(Text)}
    labels = [axis.label for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    shown = [text.get_text() for text in figure.findobj(Text) if text not in ticks or text in labels]
    return SYMBOLS.sub("", PLACES.sub("", "\n".join(shown))), ends


def check_figure(result):
    """Fail unless the texts of a figure follow the units, and the limits of each axis the unit of its label."""
    (before, ends), (after, changed) = (drawn(result, *chosen) for chosen in (BEFORE, AFTER))
    check_texts(before, after)
    for (label, old), (new_label, new) in zip(ends, changed, strict=True):
        pairs = zip(BEFORE, FACTORS, strict=True)
        factor = next((factor for name, factor in pairs if f"({name})" in label), 1.0)
        assert not label or new == pytest.approx(factor * old, rel=1e-6, abs=1e-9 * np.ptp(new)), (label, new_label)


def check_texts(before, after):
    """Fail unless two texts have the chosen units alone, and each number scales with its unit or stays."""
    for text, chosen in ((before, BEFORE), (after, AFTER)):
        assert {name.replace("\N{MICRO SIGN}", "u") for name in UNIT.findall(text)} <= {*chosen}
    numbers = [[float(number.replace(",", "")) for number in NUMBER.findall(text)] for text in (before, after)]
    for a, b in zip(*numbers, strict=True):
        assert any(math.isclose(a * factor, b, rel_tol=0.01, abs_tol=0.006) for factor in (1.0, *FACTORS)), (a, b)
    return numbers


def check_units(before, after):
    """Fail unless two texts differ in their units alone, and numbers of each unit scale with it."""
    numbers = check_texts(before, after)
    for name, factor in zip(BEFORE, FACTORS, strict=True):
        if name in UNIT.findall(before):
            assert any(a != b and math.isclose(a * factor, b, rel_tol=0.01) for a, b in zip(*numbers, strict=True))


@pytest.mark.usefixtures("few_speeds")
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in studies.STUDIES]
)
def test_chosen_units_act_on_the_numbers_and_the_figure_of_a_study(name):
    result = getattr(studies, name)(**ARGUMENTS[name])
    check_units(shown(result, *BEFORE), shown(result, *AFTER))
    if isinstance(result, DrawnResult):
        check_figure(result)
    if name != "tables":  # whose frequencies are those of the thesis
        assert "rad/s" not in UNIT.findall(shown(result))


def test_chosen_units_act_on_all_numbers_of_an_assessment():
    assessment = assess(BLOWER, only=("critical_map", "envelope"))
    check_units(*(text_of_page(assessment, *chosen) for chosen in (BEFORE, AFTER)))
    assert "rpm" in UNIT.findall(text_of_page(assessment))


@pytest.mark.slow
def test_chosen_units_act_on_the_answer_of_an_assessment(runner):
    printed = runner("assess", "turbo_expander", "--no-pdf", "--units", "Hz", "--only", "unbalance").stdout
    assert "Hz" in UNIT.findall(printed)
    assert "rpm" not in UNIT.findall(printed)


def test_chosen_units_act_on_the_description_of_a_machine_file(runner):
    texts = [
        runner("assess", "turbo_expander", "--check", "--units", ",".join(some)).stdout for some in (BEFORE, AFTER)
    ]
    check_units(*(PLACES.sub("", text) for text in texts))


def test_chosen_units_act_on_the_figure_of_a_controller():
    file = Path(rotor_literature.__path__[0]) / "controllers" / "compressor_lead_sections.toml"
    check_figure(describe_controller(file, "9000 rpm", [300.0, 1000.0]))
