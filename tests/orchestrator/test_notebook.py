"""What a notebook shows of a result and of the live rig."""

import json
import re
from html import unescape

import numpy as np

import amb_cosim
from amb_analysis.linear.components import LinearComponent
from amb_analysis.linear.model import linear_model
from amb_cosim import studies
from amb_cosim.controllers.laws import Law
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.result import Result
from amb_live.notebook import LivePage
from tests.support.messages import raises_naming

COMPLETED = Outcome("completed", 0.4, "", "")


def shown(dataset, outcome=COMPLETED):
    values = [outcome.status, outcome.time, outcome.component, outcome.reason]
    return Result(dataset.assign_attrs(outcome=json.dumps(values)), outcome)._repr_html_()


def test_a_result_shows_verdict_orbits_forces_and_key_values(synthetic):
    """The rotor is free of contact from cycle 12 on, of 20."""
    html = shown(synthetic())
    assert "recovered: the rotor touched and is free of contact since cycle 11.99" in html
    assert re.findall('<img alt="([a-z]+) of synthetic"', html) == ["orbits", "contact"]
    assert html.count("data:image/png;base64,iVBOR") == 2
    assert html.index("largest contact force") < html.index("<details>") < html.index("peak contact force")


def test_a_result_without_samples_shows_how_it_ended(synthetic):
    html = shown(synthetic().isel(time=slice(0, 0)), Outcome("failed", 0.1, "rotor", "the rotor <left>"))
    assert "<img" not in html
    assert "the rotor &lt;left&gt;" in html


def test_the_live_rig_is_a_frame_that_holds_its_whole_page(tmp_path):
    text = '<!doctype html><p title="a & b">rig</p>'
    result = LivePage("pump <1>", text, 700)
    frame = result._repr_html_()
    assert unescape(re.search('srcdoc="([^"]*)"', frame)[1]) == text
    assert "height: 700px" in frame
    assert "pump <1>" not in frame
    assert result.save(tmp_path / "rig.html").read_text(encoding="utf-8") == text


def test_the_package_of_the_live_rig_is_a_function():
    with raises_naming(ValueError, "height", "20 px"):
        amb_cosim.live(height=20)


def test_a_linear_model_of_any_size_fits_a_screen():
    """It shows names and units in place of its matrices, whose numbers no reader wants."""
    n = 60
    law = Law(-np.eye(n), np.ones((n, 1)), np.ones((1, n)), np.zeros((1, 1)))
    model = linear_model(LinearComponent(law, ("rotor.f_x",), ("rotor.x",)), {"rotor.x": "m"}, {"Omega": 90.0})
    assert repr(model) == "LinearModel(60 states, 1 inputs, 1 outputs, continuous)"
    html = model._repr_html_()
    assert "rotor.f_x" in html
    assert "Omega = 90" in html
    assert html.count("\n") < 20
    assert "max-height" in html


def test_a_study_shows_its_tables_in_a_notebook():
    result = studies.modes(speeds="90 rad/s", count=3)
    assert "rad/s" in unescape(result._repr_html_())
