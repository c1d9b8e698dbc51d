"""Views into flat arrays: the same compiled and in plain Python, and into the same memory."""

from typing import NamedTuple

import numpy as np
import pytest

from fmi_export.jit import kernel, views
from fmi_export.parts import clear, copy_all, part
from fmi_export.records import record

ITEM = record(("a", "f8"), ("b", "c16", (2,)))
COMPLEX, REAL = np.dtype(np.complex128), np.dtype(np.float64)


@kernel
def exchange(numbers, start, n, m):
    """Read and write through records, a matrix and a cube; return a sum in which every place has its weight."""
    items = part(numbers, start, ITEM, n)
    matrix = part(numbers, start + 5 * n, COMPLEX, (n, m))
    cube = part(numbers, start, COMPLEX, (2, n, m))
    total = 0.0
    for i in range(n):
        total += (i + 1) * (items[i].a + 10.0 * items[i].b[1].imag)
        for j in range(m):
            total += (j + 1) * (100.0 * matrix[i, j].real + matrix[i, j].imag) - cube[1, i, j].imag
    matrix[n - 1, m - 1] = 7.0 + 8.0j
    copy_all(matrix[0], matrix[1])
    clear(part(numbers, 0, REAL, start))
    return total


@pytest.mark.parametrize(("start", "n", "m"), [(0, 2, 1), (1, 2, 3), (3, 4, 2)])
def test_compiled_views_equal_those_of_plain_python(start, n, m):
    compiled = np.arange(1.0, 100.0)
    plain = compiled.copy()
    assert exchange(compiled, start, n, m) == exchange.py_func(plain, start, n, m)
    np.testing.assert_array_equal(compiled, plain)
    assert not compiled[:start].any()
    last = start + 5 * n + 2 * (n * m - 1)
    assert list(compiled[last : last + 2]) == ([7.0, 8.0] if n > 2 else list(compiled[last - 2 * m : last - 2 * m + 2]))


def test_a_part_is_a_view():
    numbers = np.zeros(6)
    part(numbers, 1, COMPLEX, 2)[1] = 3.0 + 4.0j
    assert list(numbers) == [0.0, 0.0, 0.0, 3.0, 4.0, 0.0]


class Memory(NamedTuple):
    """An array of numbers and one of records, as a function passes them to kernels."""

    numbers: np.ndarray
    items: np.ndarray


@views
def memory_of(numbers):
    """Return views of five numbers after the first."""
    return Memory(part(numbers, 1, REAL, 2), part(numbers, 1, ITEM, 1))


@kernel
def store(numbers, i):
    """Write through views that are not read afterwards, at indices known only at run time."""
    memory_of(numbers).numbers[i] = 1.0
    part = memory_of(numbers).items[0]
    for k in range(2):
        part.b[k] = complex(k, i)


def test_values_stored_through_returned_views_reach_the_array():
    compiled = np.zeros(6)
    plain = compiled.copy()
    store(compiled, 0)
    store.py_func(plain, 0)
    assert list(compiled) == list(plain) == [0.0, 1.0, 0.0, 0.0, 1.0, 0.0]
