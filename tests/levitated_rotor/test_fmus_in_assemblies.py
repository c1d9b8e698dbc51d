"""Components that cannot become parts of an assembly are refused with the cause."""

from amb_cosim.cosim.system.system import Component, System
from amb_cosim.export.planned import made_for
from tests.support.messages import raises_naming


def test_an_fmu_in_place_of_a_model_is_named(tmp_path):
    fmu = tmp_path / "own.fmu"
    fmu.touch()
    system = System("pump", "A pump.", (Component("controller", str(fmu)),), ())
    with raises_naming(ValueError, "controller", "pump", str(fmu), "an FMU already", "rotor_contact"):
        made_for(system)
