"""Unit conversions, strings and isolated FMUs, in both loops and in every order.

Speed y in m/s is 0.5 m/s2 t after n steps of h = 0.1 s; the second FMU gets it in mm/s, plus 2 mm/s, and integrates:

    y_2 = h sum_k (1000 y_1(t_k) + 2),   k = 1 ... 10 in Gauss-Seidel and iterative order, 0 ... 9 in Jacobi order
"""

import pytest
from informed import informed_fmu
from slow import slow_but_first

import amb_cosim
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system import Component, Connection, System
from tests.cosim.test_variables import DESCRIPTIONS, SOURCE
from tests.support.messages import raises_naming

WAYS = {
    "compiled": {"loop": "compiled", "isolated": False},
    "plain": {"loop": "plain", "isolated": False},
    "isolated": {"loop": "compiled", "isolated": True},
    "isolated plain": {"loop": "plain", "isolated": True},
}
LAST = {"gauss_seidel": 277.0, "iterative": 277.0, "jacobi": 227.0}  # 0.1 (1000 * 0.05 * 55 + 20), and with 45


@pytest.mark.parametrize("coupling", LAST)
@pytest.mark.parametrize("once", slow_but_first(["false", "true"]), ids="separate {}".format)
@pytest.mark.parametrize("way", slow_but_first(["compiled", "plain", "isolated", "isolated plain"]))
def test_unit_conversion_is_the_same_in_every_loop(fmu_from_c, tmp_path, coupling, once, way):
    fmu = str(informed_fmu(fmu_from_c, tmp_path, 2, canBeInstantiatedOnlyOncePerProcess=once))
    system = System(
        "converted",
        "",
        (Component("first", fmu), Component("second", fmu)),
        (Connection("first.y", "second.u", factor=1000.0, offset=2.0, converts_units=True),),
        coupling=coupling,
    )
    experiment = Experiment(0.1, 1.0, settles=False, inputs={"first.u": 0.5})
    data = amb_cosim.simulate(system, experiment, **WAYS[way]).dataset
    assert data["first.y"].values[-1] == pytest.approx(0.5)
    assert data["second.y"].values[-1] == pytest.approx(LAST[coupling])


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("way", slow_but_first(["plain", "compiled", "isolated", "isolated plain"]))
def test_texts_reach_fmus_of_a_system_in_every_loop(fmu_from_c, tmp_path, coupling, way):
    """Each of the two gets its text, whose length it adds to 1000; the second is integrated in mm/s."""
    texts, other = fmu_from_c(SOURCE, DESCRIPTIONS[2], 2), fmu_from_c(SOURCE, DESCRIPTIONS[3], 3)
    fmu = informed_fmu(fmu_from_c, tmp_path, 2)
    system = System(
        "texts",
        "",
        (Component("one", str(texts)), Component("two", str(other)), Component("sum", str(fmu))),
        (Connection("two.y", "sum.u", factor=0.001, converts_units=True),),
        coupling=coupling,
        parameters={"one": {"file": "a.csv"}, "two": {"file": "Lüfter.csv"}},
    )
    data = amb_cosim.simulate(system, Experiment(0.1, 1.0, settles=False), **WAYS[way]).dataset
    assert [data[f"{name}.y"].values[-1] for name in ("one", "two", "sum")] == pytest.approx([1005.0, 1011.0, 1.011])


def test_an_integer_of_an_archive_feeds_a_real(fmu_from_c, tmp_path):
    """The output `fault_code` is 1, which the second FMU integrates; systems of other files must have equal types."""
    texts, fmu = fmu_from_c(SOURCE, DESCRIPTIONS[2], 2), informed_fmu(fmu_from_c, tmp_path, 2)
    components = Component("one", str(texts)), Component("two", str(fmu))
    for converts in (True, False):
        link = Connection("one.fault_code", "two.u", converts_units=converts)
        system = System("integer", "", components, (link,))
        if converts:
            data = amb_cosim.simulate(system, Experiment(0.1, 1.0, settles=False), isolated=False).dataset
            assert data["two.y"].values[-1] == pytest.approx(1.0)
        else:
            with raises_naming(ValueError, "one.fault_code", "Integer", "two.u", "Real"):
                amb_cosim.simulate(system, Experiment(0.1, 1.0, settles=False), isolated=False)
