"""Native FMUs give the results of those that PythonFMU runs."""

from typing import Any

import pytest

import amb_cosim

pytestmark = [pytest.mark.slow, pytest.mark.gate]

pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")

RIG = dict.fromkeys(("fig4_9", "fig4_18", "fig5_6"))
SHORT = {  # s
    "nelson_mcvaugh_rub": 0.024,
    "compressor_touchdown": 0.04,
    "compressor_levitated_touchdown": 0.04,
    "turbo_pump_air_inrush": 0.02,
}


CASES = [pytest.param(name, until, {}, None, id=name) for name, until in (RIG | SHORT).items()]
WORN = {"rotor_contact.rb?.clearance": "5 mm", "rotor_contact.eb?.enabled": False}
YIELDING = {"rotor_contact.rb?.law": "kelvin_voigt", "rotor_contact.rb?.k_c": "1e8 N/m", "rotor_contact.rb?.c_c": 1e4}
CASES += [
    pytest.param("drop", 0.03, WORN, "stator_mb1", id="drop onto the stators"),
    pytest.param("drop_no_race", 0.03, YIELDING, "rb1", id="drop under a force law"),
]


@pytest.mark.parametrize(("name", "until", "settings", "touched"), CASES)
def test_both_flavours_give_the_same_bits(
    name: str, until: float | None, settings: dict[str, Any], touched: str | None
) -> None:
    native, python = (
        amb_cosim.run(name, set=settings, flavour=f, until=until, progress=False) for f in ("native", "python")
    )
    assert native.outcome == python.outcome
    assert native.outcome.failure is None
    names = list(native.signals.variables)
    assert names == list(python.signals.variables)
    assert [n for n in names if native.signals[n].values.tobytes() != python.signals[n].values.tobytes()] == []
    assert len(names) > (80 if name in RIG else 20)
    forces = {n.split(".")[1]: native.signals[n].values.max() for n in names if n.endswith(".f_n")}
    assert max(forces.values()) > 100.0
    assert touched is None or forces[touched] > 100.0
