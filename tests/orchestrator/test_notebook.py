"""What a notebook shows of a result and of the live rig."""

import json
import re
from html import unescape

from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.result import Result
from amb_live.notebook import LivePage

COMPLETED = Outcome("completed", 0.4, "", "")


def shown(dataset, outcome=COMPLETED):
    values = [outcome.status, outcome.time, outcome.component, outcome.reason]
    return Result(dataset.assign_attrs(outcome=json.dumps(values)), outcome)._repr_html_()


def test_a_result_shows_verdict_orbits_forces_and_key_values(synthetic):
    """The rotor is free of contact from cycle 12 on, of 20."""
    html = shown(synthetic())
    assert "recovered: the rotor touched and has been free of contact since cycle 11.99" in html
    assert re.findall('<img alt="([a-z]+) of synthetic"', html) == ["orbits", "contact"]
    assert html.count("data:image/png;base64,iVBOR") == 2
    assert html.index("largest contact force") < html.index("<details>") < html.index("largest force between impacts")


def test_a_result_without_samples_shows_its_outcome(synthetic):
    html = shown(synthetic().isel(time=slice(0, 0)), Outcome("failed", 0.1, "rotor", "the rotor <left>"))
    assert "<img" not in html
    assert "the rotor &lt;left&gt;" in html


def test_the_live_rig_is_a_frame_with_its_whole_page(tmp_path):
    text = '<!doctype html><p title="a & b">rig</p>'
    result = LivePage("pump <1>", text, 700)
    frame = result._repr_html_()
    assert unescape(re.search('srcdoc="([^"]*)"', frame)[1]) == text
    assert "height: 700px" in frame
    assert "pump <1>" not in frame
    assert result.save(tmp_path / "rig.html").read_text(encoding="utf-8") == text
