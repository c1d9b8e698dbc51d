"""The page of the live rig in Debian's Chromium: display and controls."""

import numpy as np
import pytest
from live_browser import FASTEST

import amb_cosim

pytestmark = pytest.mark.slow  # the engine is compiled as WebAssembly first

END = 2.5  # s, of fig5_6_pid


def test_page_opened_from_a_file_runs_and_draws(open_rig):
    rig = open_rig(reduced_motion="no-preference")
    rig.page.wait_for_function("parseFloat(document.querySelector('#clock').textContent) > 0.02")
    for canvas in ("#shaft", "#polar", ".orbit canvas", ".chart canvas", "#line-canvas"):
        colours = rig.page.eval_on_selector(
            canvas,
            """(canvas) => new Set(new Uint32Array(
                canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size""",
        )
        assert colours > 5, canvas


def test_the_keyboard_runs_pauses_steps_and_resets(open_rig):
    rig = open_rig()
    rig.page.keyboard.press(" ")
    rig.page.wait_for_function("parseFloat(document.querySelector('#clock').textContent) > 0.005")
    rig.page.keyboard.press(" ")
    rig.page.wait_for_function("document.querySelector('#achieved').textContent === 'paused'")
    before = rig.time
    rig.page.keyboard.press("s")
    rig.page.wait_for_function("(t) => parseFloat(document.querySelector('#clock').textContent) > t", arg=before)
    rig.page.keyboard.press("r")
    rig.reach(0.0)
    rig.page.keyboard.press("?")
    assert rig.page.is_visible("#help-dialog")


def test_contact_aware_rolac_frees_a_rotor_that_is_trapped(open_rig):
    rig = open_rig()
    rig.page.click("button[data-option=Contact-aware]")
    rig.page.click("#apply")
    rig.page.wait_for_selector("#pending", state="hidden")
    rig.reach(0.0)
    rig.page.click("button[data-option=PID]")
    rig.go(1.5)
    assert rig.modes == ["1", "1"]
    rig.page.click("button[data-option=Contact-aware]")
    rig.page.fill("#pace", FASTEST)
    rig.page.click("#play")
    rig.reach(END)  # where the scenario ends
    assert rig.modes == ["0", "0"]


def test_the_original_scenario_discards_all_changes(open_rig):
    rig = open_rig()
    rig.page.click("button[data-option=ROLAC]")
    rig.page.wait_for_selector("button[data-option=ROLAC][aria-pressed=true]")
    rig.page.click("#original")
    rig.page.wait_for_selector("button[data-option=PID][aria-pressed=true]")


def test_bad_input_shows_the_message_of_the_fmu(open_rig):
    rig = open_rig()
    rig.set("rotor_contact.d1.u", -1)
    rig.page.wait_for_selector("#failure:not([hidden])")
    text = rig.page.inner_text("#failure")
    assert "d1.u" in text
    assert "-1 kg.m" in text
    assert rig.page.get_attribute("#failure", "role") == "alert"


def test_a_fixed_parameter_takes_effect_at_the_next_start(open_rig):
    rig = open_rig()
    rig.go(0.05)
    rig.set("rotor_contact.rb1.mu", 0.25)
    assert "rotor_contact.rb1.mu takes effect when the run is reset" in rig.page.inner_text("#pending")
    rig.page.click("#apply")
    rig.reach(0.0)
    rig.page.fill("#variable-name", "rotor_contact.rb1.mu")
    assert rig.page.input_value("#variable-value") == "0.25"


# In contact, or less than 600 um of 750 away from it.
IS_NEAR = """() => {
  const [what, gap] = document.querySelector('.contact .value').textContent.split(' ');
  return what !== 'gap' || Number(gap) < 600;
}"""


def test_dragging_in_an_orbit_pushes_until_the_pointer_is_released(open_rig):
    rig = open_rig()
    rig.page.fill("#pace", "-1")
    rig.page.click("#play")
    box = rig.page.locator(".orbit canvas").first.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    rig.page.mouse.move(x, y)
    rig.page.mouse.down()
    rig.page.mouse.move(x + 60, y, steps=4)
    rig.page.wait_for_function("document.querySelector('.orbit .force').textContent.startsWith('push')")
    rig.page.wait_for_function(IS_NEAR, timeout=120_000.0)
    rig.page.mouse.up()
    rig.page.wait_for_function("!document.querySelector('.orbit .force').textContent.startsWith('push')")


def test_a_saved_scenario_repeats_the_run_of_the_page(open_rig, tmp_path):
    rig = open_rig()
    rig.go(0.1)
    rig.set("rotor_contact.d4.u", 0.02)
    rig.page.click("button[data-option=ROLAC]")
    rig.page.wait_for_selector("button[data-option=ROLAC][aria-pressed=true]")
    rig.go(0.6)
    for button, name in (("#save", "done.toml"), ("#csv", "shown.csv")):
        with rig.page.expect_download() as download:
            rig.page.click(button)
        download.value.save_as(tmp_path / name)
    exported = np.genfromtxt(tmp_path / "shown.csv", delimiter=",", names=True, deletechars="", replace_space=" ")
    again = amb_cosim.run(tmp_path / "done.toml").dataset
    clearance = 0.75e-3
    for axis in ("mb1.x", "mb2.y"):
        repeated = again[f"rotor_contact.{axis}"].interp(time=exported["time (s)"])
        assert float(abs(repeated - exported[f"rotor_contact.{axis} (m)"]).max()) < 1e-6 * clearance  # single precision
    assert float(again["rotor_contact.rb1.f_n"].max()) > 0.0


def test_a_link_holds_all_changes(open_rig):
    rig = open_rig()
    rig.go(0.05)
    rig.set("rotor_contact.d3.u", 0.007)
    rig.page.wait_for_function("document.querySelector('[data-variable=\"rotor_contact.d3.u\"]').value === '7'")
    rig.page.click("#share")
    again = open_rig(rig.page.url)
    again.go(0.1)
    assert again.page.input_value('[data-variable="rotor_contact.d3.u"]') == "7"


def test_a_damaged_link_is_reported(open_rig, page_file):
    rig = open_rig(f"{page_file.as_uri()}#fig5_6_pid=%%%")
    assert "damaged" in rig.page.inner_text("#failure")


def test_another_scenario_can_be_chosen(open_rig):
    rig = open_rig()
    rig.page.select_option("#scenario", "drop")
    rig.page.wait_for_function("document.querySelectorAll('.contact').length === 4")  # with the bushes
    rig.settled()
    assert "rotor falls" in rig.page.inner_text("#description")
    assert "2483 rpm" in rig.page.inner_text("#description")
    rig.go(0.2)
    assert "1" in rig.modes


def test_speed_is_reached_at_the_chosen_rate(open_rig):
    rig = open_rig()
    rig.page.fill("#speed-field", "1050.4226")
    rig.page.press("#speed-field", "Enter")
    rig.go(0.1)
    assert "960\u00a0rpm" not in rig.page.inner_text("#control-state")
    rig.go(0.3)
    assert "1050\u00a0rpm" in rig.page.inner_text("#control-state")


def test_an_experiment_waits_for_the_push_and_comments_on_it(open_rig):
    rig = open_rig()
    rig.page.click("#play")
    rig.page.wait_for_function("document.querySelector('#guide .say').textContent.startsWith('Push it')")
    rig.page.focus(".orbit canvas")
    rig.page.keyboard.down("ArrowRight")
    rig.page.wait_for_function("document.querySelector('#guide .say').textContent.startsWith('Let go')")
    rig.page.keyboard.up("ArrowRight")
    rig.page.wait_for_function("document.querySelectorAll('#guide .remarks li').length === 3", timeout=120_000.0)


def test_a_push_while_paused_says_that_the_run_is_paused(open_rig):
    rig = open_rig()
    rig.page.focus(".orbit canvas")
    rig.page.keyboard.press("ArrowRight")
    assert "paused" in rig.page.inner_text("#notice")


def test_control_that_works_is_offered_if_the_chosen_one_fails(open_rig):
    rig = open_rig()
    rig.go(1.5)
    rig.page.click("button[data-option=ROLAC]")
    rig.page.click(".advice button")
    assert "contact.aware" in rig.page.inner_text("#pending")


def test_every_control_has_a_name_and_can_be_reached_by_keyboard(open_rig):
    rig = open_rig()
    rig.page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    nameless = rig.page.evaluate(
        """[...document.querySelectorAll("button, input, select, canvas[tabindex]")]
            .filter((one) => !(one.ariaLabel || one.textContent.trim() || one.title || one.labels?.length))
            .map((one) => one.outerHTML)"""
    )
    assert nameless == []
    skipped = rig.page.evaluate(
        "[...document.querySelectorAll('button, input, select')].filter((one) => one.tabIndex < 0).length"
    )
    assert skipped == 0


def test_theory_is_one_click_away(open_rig):
    rig = open_rig()
    rig.page.click(".orbits a[data-theory=contact]")
    assert "4.14" in rig.page.inner_text("#theory-text")
    assert rig.page.get_attribute("#theory-text a", "href") == "docs/theory/contact.html"
