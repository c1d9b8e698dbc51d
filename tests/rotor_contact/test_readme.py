"""The README shows code that runs."""

import shutil

import pytest
from code_blocks import example_of
from rotor_cases import OnePlane

from amb_cosim.model_constants.plant_data import plant
from rotor_analysis.rotor_file import load_rotor


def test_example_in_the_readme_shows_the_orbit_of_the_complex_model(build_fmu, run_python, tmp_path):
    shutil.copy(build_fmu(*plant()), tmp_path)
    code = (
        example_of("rotor_contact")
        + "\nresult = [float(centre.real), float(centre.imag), float(radius), int(result['contact_state'].max())]\n"
    )
    x, y, radius, contact = run_python(code, cwd=tmp_path, timeout=120)
    model = OnePlane.of(load_rotor(), 1e6, 5000.0)
    orbit = model.orbit(90.0, [5e-3, 0, 0, 0])
    assert radius == pytest.approx(abs(orbit[model.bearings[0]]), rel=1e-4)
    assert (x, y) == (pytest.approx(100.0 / 1e6, rel=1e-4), pytest.approx(0.0, abs=1e-8))  # 100 N on 1e6 N/m
    assert contact == 0
