"""Which communication step in Jacobi order is in doubt follows from how fast the controller samples."""

import pytest

from amb_cosim.scenario.coupling import coupling_warning
from tests.support.messages import assert_names


@pytest.mark.parametrize(
    ("sample_time", "allowed", "told", "facts"),
    [
        (250e-6, 50e-6, 51e-6, ("50 us", "controller's sample time")),
        (100e-6, 20e-6, 25e-6, ("20 us", "controller's sample time")),
        (None, 50e-6, 51e-6, ("50 us", "250 us")),
    ],
)
def test_a_jacobi_step_beyond_a_fifth_of_the_sample_time_is_in_doubt(sample_time, allowed, told, facts):
    assert coupling_warning("jacobi", allowed, 0.0, sample_time) is None
    assert coupling_warning("gauss_seidel", told, 0.0, sample_time) is None
    assert_names(coupling_warning("jacobi", told, 0.0, sample_time), *facts)
