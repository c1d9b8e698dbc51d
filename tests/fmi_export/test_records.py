"""Records, the views of flat arrays in kernels."""

import numpy as np
import pytest

from fmi_export.interface import interface, repeated
from fmi_export.jit import kernel
from fmi_export.records import record, record_of, size_of
from fmi_export.variables import output, parameter
from tests.support.messages import raises_naming

PLACES = ("law", "chain.noise", "chain.delay", *(f"sites[{k}].{name}" for k in range(3) for name in ("gap", "mu")))
MATRIX = tuple(f"r[{i},{j}].{part}" for i in range(2) for j in range(3) for part in ("re", "im"))


@kernel
def double_gaps(array: np.ndarray, matrix: np.ndarray) -> float:
    p = array.view(RECORD)[0]
    total = 0.0
    for k in range(3):
        p.sites[k].gap = 2.0 * p.sites[k].gap
        total += p.sites[k].mu
    m = matrix.view(OF_MATRIX)[0]
    m.r[1, 2] = 1j * m.r[0, 1]
    return total + p.chain.delay


RECORD, OF_MATRIX = record_of(PLACES), record_of(MATRIX)


@pytest.mark.parametrize("compiled", [True, False])
def test_a_record_reads_and_writes_the_numbers_of_its_array(compiled: bool) -> None:
    array, matrix = np.arange(float(len(PLACES))), np.arange(float(len(MATRIX)))
    function = double_gaps if compiled else getattr(double_gaps, "py_func", double_gaps)
    assert function(array, matrix) == 4.0 + 6.0 + 8.0 + 2.0
    np.testing.assert_array_equal(array, [0.0, 1.0, 2.0, 6.0, 4.0, 10.0, 6.0, 14.0, 8.0])
    np.testing.assert_array_equal(matrix[-2:], [-3.0, 2.0])


def test_fields_of_a_record_are_in_the_order_of_the_array() -> None:
    array = np.arange(float(len(PLACES)))
    p = array.view(RECORD)[0]
    assert [p.law, p.chain.noise, p.chain.delay] == [0.0, 1.0, 2.0]
    assert [[site.gap, site.mu] for site in p.sites] == [[3.0, 4.0], [5.0, 6.0], [7.0, 8.0]]
    assert size_of(RECORD) == len(PLACES)
    np.testing.assert_array_equal(np.arange(12.0).view(OF_MATRIX)[0].r.view(np.float64).ravel(), np.arange(12.0))


@pytest.mark.parametrize(
    ("places", "facts"),
    [
        (("sites[0].gap", "law", "sites[1].gap"), ("next to",)),
        (("sites[0].gap", "sites[1].mu"), ("sites", "same structure")),
        (("law", "law"), ("law",)),
        (("sites[1].gap",), ("next to",)),
        (("2nd", "law"), ("2nd",)),
    ],
)
def test_numbers_out_of_order_are_refused(places: tuple[str, ...], facts: tuple[str, ...]) -> None:
    with raises_naming(ValueError, *facts):
        record_of(places)


def test_the_records_of_an_interface_follow_its_table() -> None:
    def site(name: str) -> list:
        return [
            parameter(f"{name}.clearance", "m", "", 1.0),
            parameter(f"{name}.mu_x", "1", "", 0.0, field="mu"),
            output(f"{name}.gap", "m", ""),
        ]

    table = interface(
        parameter("law", "1", "", 0.0),
        *repeated("sites", [("rb1",), ("rb2",)], site),
        *repeated("planes", [(k,) for k in range(4)], lambda k: [output(f"s{k}", "m", "", field=".")], shape=(2, 2)),
        output("fault_code", "1", "", type="Integer"),
    )
    parameters, inputs, outputs = table.records
    assert parameters.names == ("law", "sites")
    assert parameters["sites"].base.names == ("clearance", "mu")
    assert inputs.itemsize == 0
    assert outputs["planes"].shape == (2, 2)
    assert table.start[: table.n_parameters].view(parameters)[0].sites[1].clearance == 1.0


def test_declared_memory_has_the_size_of_its_layout() -> None:
    layout = record(("phase", "f8"), ("forces", "c16", (2, 4)))
    assert size_of(layout) == 1 + 16
