"""The table in the controller: interpolation, renewal, order, room."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from rig import NO_TABLE, SIZES, given_parameters, pack

from amb_cosim.model_constants.controller_data import inverse_receptance
from rolac_controller.pseudo_inverse import svd_work_of, svd_work_size
from rolac_controller.receptance_table import (
    BEYOND,
    MISSING,
    SPARE_ROWS,
    WITHIN,
    built_table,
    find_bracket,
    interpolate,
    load,
    store,
    table_in_use,
    table_size,
)


def loaded(constants, weights=None):
    table = table_in_use(np.zeros(table_size(constants)), 0, constants, SIZES)
    parameters = given_parameters({f"s{k}.weight": w for k, w in enumerate([] if weights is None else weights, 1)})
    ok = load(built_table(constants, SIZES), parameters, table, svd_work_of(np.zeros(svd_work_size(SIZES)), 0, SIZES))
    return table if ok else None


def matrix_at(table, speed, name="H", order=1.0):
    lower, upper, weight, coverage = find_bracket(table, order, speed)
    matrix = np.zeros((4, 8) if name == "H" else (8, 4), dtype=complex)
    of_rows = getattr(table, name)
    interpolate(of_rows[lower], of_rows[upper], weight, matrix)
    return matrix, coverage


def rows(table):
    return [(row.order, row.speed) for row in table.keys[: int(table.n_rows[0])]]


def store_uniform(table, order, speed, r=1.0, h=1.0):
    """Store matrices of equal elements."""
    return store(table, order, speed, np.full((8, 4), r, dtype=complex), np.full((4, 8), h, dtype=complex))


def test_table_gives_h_and_r_at_its_speeds_exactly_and_linearly_between(receptance):
    speeds = np.array([31.4, 62.8, 157.0])
    receptances = np.array([receptance, 1j * receptance + 1e-7, 0.3 * receptance - 2e-7j])
    table = loaded(pack(speeds, receptances))
    h = [inverse_receptance(r) for r in receptances]
    for k in range(3):
        np.testing.assert_array_equal(matrix_at(table, speeds[k])[0], h[k])
        np.testing.assert_array_equal(matrix_at(table, speeds[k], "R")[0], receptances[k])
    between = 62.8 + 0.25 * 94.2
    np.testing.assert_allclose(matrix_at(table, between)[0], 0.75 * h[1] + 0.25 * h[2], rtol=1e-12)
    expected = 0.75 * receptances[1] + 0.25 * receptances[2]
    np.testing.assert_allclose(matrix_at(table, between, "R")[0], expected, rtol=1e-12)


def test_table_is_constant_beyond_its_ends_with_a_flag(receptance):
    table = loaded(pack([50.0, 100.0], [receptance, 2.0 * receptance]))
    for speed, end, expected in [(10.0, 50.0, BEYOND), (50.0, 50.0, WITHIN), (100.0, 100.0, WITHIN)]:
        h, result = matrix_at(table, speed)
        np.testing.assert_array_equal(h, matrix_at(table, end)[0])
        assert result == expected
    np.testing.assert_array_equal(matrix_at(table, 500.0)[0], matrix_at(table, 100.0)[0])
    assert matrix_at(table, 500.0)[1] == BEYOND


def test_each_harmonic_has_its_own_speeds(receptance):
    table = loaded(pack([50.0, 100.0], [[receptance, 2 * receptance], [3 * receptance, 4 * receptance]], orders=(1, 3)))
    np.testing.assert_array_equal(matrix_at(table, 100.0, "R")[0], 2 * receptance)
    np.testing.assert_array_equal(matrix_at(table, 100.0, "R", order=3.0)[0], 4 * receptance)
    assert matrix_at(table, 100.0, order=2.0)[1] == MISSING


def test_empty_table_has_no_h():
    assert find_bracket(loaded(NO_TABLE), 1.0, 100.0).coverage == MISSING


@given(st.lists(st.tuples(st.integers(1, 3), st.floats(1.0, 1e3)), max_size=SPARE_ROWS))
def test_receptances_are_sorted_by_speed_whatever_their_order(entries):
    """The last receptance within 0.5 % of a speed applies; rows stay ascending and keep their values."""
    table = loaded(NO_TABLE)
    for number, (order, speed) in enumerate(entries):
        assert store_uniform(table, float(order), speed, number + 0.5, -number)
    result = rows(table)
    assert result == sorted(set(result))
    for k, (order, speed) in enumerate(result):
        number = int(table.R[k][0, 0].real)
        assert entries[number] == (order, speed)
        np.testing.assert_array_equal(table.R[k], number + 0.5)
        np.testing.assert_array_equal(table.H[k], -number)
    for order, speed in entries:
        assert any(o == order and abs(s - speed) <= 0.011 * speed for o, s in result)


def test_receptance_at_a_speed_of_the_table_replaces_its_nearest(receptance):
    table = loaded(pack([100.0, 100.3, 200.0], [receptance] * 3))
    store_uniform(table, 1.0, 100.4)
    assert rows(table) == [(1.0, 100.0), (1.0, 100.4), (1.0, 200.0)]


def test_full_table_takes_replacements_only():
    table = loaded(NO_TABLE)
    for k in range(SPARE_ROWS):
        assert store_uniform(table, 1.0, 10.0 * (k + 1))
    before = [part.copy() for part in table]
    assert not store_uniform(table, 1.0, 5.0)
    for part, old in zip(table, before, strict=True):
        np.testing.assert_array_equal(part, old)
    assert table.n_rows[0] == SPARE_ROWS
    assert store_uniform(table, 1.0, 10.0)
