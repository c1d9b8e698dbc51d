"""What FMUs are told of the start and the end of a run, and the values with which it begins."""

from __future__ import annotations

import sys

import pytest
from informed import informed_fmu
from slow import slow_but_first

import amb_cosim

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")


@pytest.fixture(params=slow_but_first([2, 3]), ids="FMI {}".format)
def run(request, fmu_from_c, tmp_path):
    """`run(experiment, components, **options)`: a run of FMUs that show what they are told, one after the other."""

    def simulate(experiment, components="one", more="", flags=None, **options):
        fmu = informed_fmu(fmu_from_c, tmp_path, request.param, **(flags or {}))
        parts = [f'[[component]]\nname = "{name}"\nfmu = "{fmu}"\n' for name in components.split()]
        path = tmp_path / "system.toml"
        path.write_text("\n".join([more, *parts, f"[experiment]\n{experiment}"]), encoding="utf-8")
        return amb_cosim.simulate(path, **options)

    return simulate


@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel", "iterative"])
@pytest.mark.parametrize(
    "options", [{}, {"loop": "plain"}, {"isolated": False}], ids=["compiled", "plain", "this process"]
)
def test_a_run_begins_with_outputs_that_initialisation_ends_with(run, coupling, options):
    # Reported publicly for FMPy (440) and for FMUs of Simulink and 20-sim, which compute outputs as it ends.
    link = f'coupling = "{coupling}"\n[[connect]]\nfrom = "first"\nto = "second"\nvariables = {{ y = "u" }}\n'
    link += "[parameters.first]\ny0 = 5.0\n"
    steps = 'communication_step = "0.1 s"\nstop_time = "1 s"'
    result = run(steps, "second first", link, **options).dataset
    assert result["first.y"].values[0] == 5.0
    assert set(result["second.used"].values[1:]) == {5.0}
    assert result["second.y"].values[-1] == pytest.approx(5.0)
