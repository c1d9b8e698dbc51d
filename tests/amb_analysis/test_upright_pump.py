"""An upright turbomolecular pump of 7.4 kg, whose bell and thrust disc decide on its stability.

The files in `upright` were drawn for this check. An independent finite-element model of the same pump has the free
modes and the growth rates below.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.machine.machine import machine_of
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor_file import load_rotor

FOLDER = Path(__file__).parent / "upright"
AT_ITS_CENTRE, AT_ITS_SEAT = "\nz = 0.135\n", "\nz = 0.216\noffset = -0.081\n"
DISC = '\n[[seals]]\nname = "disc"\nz = 0.032\ntilt_stiffness = -242.1\n'


@pytest.fixture
def pump(tmp_path):
    """Return a function that writes the pump with another rotor file."""
    for name in ("levitation.toml", "control.toml"):
        shutil.copy(FOLDER / name, tmp_path)
    text = (FOLDER / "tmp250.toml").read_text(encoding="utf-8")
    assert text.count(AT_ITS_CENTRE) == 1

    def write(bell=AT_ITS_CENTRE, more=""):
        (tmp_path / "tmp250.toml").write_text(text.replace(AT_ITS_CENTRE, bell) + more, encoding="utf-8")
        return tmp_path

    return write


def first_mode(folder):
    model = assemble(load_rotor(folder / "tmp250.toml"))
    return free_modes(model.M[::2, ::2], model.K[::2, ::2])[0][0] / (2.0 * np.pi)


def growth_at_rest(folder):
    prepared = prepare_run(as_scenario(str(folder / "levitation.toml"), None).machine())
    return machine_of(prepared).loop.poles(0.0).stability.growth_rate


def test_a_bell_on_its_hub_bends_the_shaft_at_807_hz(pump):
    at_centre = rigid_body(load_rotor(pump() / "tmp250.toml"))
    assert first_mode(pump()) == pytest.approx(1865.0, abs=1.0)
    assert first_mode(pump(AT_ITS_SEAT)) == pytest.approx(807.0, abs=1.0)
    at_seat = rigid_body(load_rotor(pump(AT_ITS_SEAT) / "tmp250.toml"))
    assert at_seat.centre == pytest.approx(at_centre.centre, rel=1e-9)
    assert at_seat.diametral_inertia == pytest.approx(at_centre.diametral_inertia, rel=1e-9)


def test_a_control_that_holds_the_bell_at_its_centre_does_not_hold_it_on_its_hub(pump):
    assert growth_at_rest(pump()) == pytest.approx(-43.2, rel=0.01)
    assert growth_at_rest(pump(AT_ITS_SEAT)) == pytest.approx(124.0, rel=0.02)


def test_the_thrust_disc_tilts_the_pump_away(pump):
    assert growth_at_rest(pump(more=DISC)) == pytest.approx(1.2, abs=0.03)
