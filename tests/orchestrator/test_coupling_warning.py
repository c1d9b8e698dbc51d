"""Which communication step in Jacobi order is in doubt follows from how fast the controller samples."""

import pytest

from amb_cosim.scenario.coupling import coupling_warning


@pytest.mark.parametrize(
    ("sample_time", "allowed", "told", "reason"),
    [
        (250e-6, 50e-6, 51e-6, "at most 50 us, a fifth of the controller's sample time"),
        (100e-6, 20e-6, 25e-6, "at most 20 us, a fifth of the controller's sample time"),
        (None, 50e-6, 51e-6, "at most 50 us, a fifth of 250 us between samples"),
    ],
)
def test_a_jacobi_step_beyond_a_fifth_of_the_sample_time_is_in_doubt(sample_time, allowed, told, reason):
    assert coupling_warning("jacobi", allowed, 0.0, sample_time) is None
    assert coupling_warning("gauss_seidel", told, 0.0, sample_time) is None
    assert reason in coupling_warning("jacobi", told, 0.0, sample_time)
