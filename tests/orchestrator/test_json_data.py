"""JSON of typed results: keys with units, arrays, complex numbers, and omitted fields."""

import json
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_cosim.presentation.json_data import JsonKey, Layout, json_data
from tests.support.messages import raises_naming


@dataclass(frozen=True)
class Part:
    speed: Annotated[float, "rad/s"]
    stiffness: Annotated[np.ndarray, "N/m"]


@dataclass(frozen=True)
class Whole:
    name: str
    parts: tuple[Part, ...]
    by_speed: dict[float, Part]
    planes: Annotated[list[float], JsonKey("planes_z_m")]
    absent: Annotated[float | None, "Hz"]
    left_out: Annotated[object, Layout.OMITTED]
    optional: Annotated[float | None, "s", Layout.OMITTED_IF_NONE] = None


@dataclass(frozen=True)
class Shape:
    response: Annotated[np.ndarray, "m/N"]
    pairs: Annotated[np.ndarray, Layout.PAIRS]


@dataclass(frozen=True)
class Unknown:
    pressure: Annotated[float, "Pa"]


def test_keys_are_names_with_units():
    part = Part(1.5, np.array([[1.0, np.nan]]))
    whole = Whole("a", (part,), {90.0: part, 104.71975: part}, [0.1], None, object())
    expected = {"speed_rad_s": 1.5, "stiffness_N_per_m": [[1.0, None]]}
    assert json_data(whole) == {
        "name": "a",
        "parts": [expected],
        "by_speed": {"90": expected, "104.72": expected},
        "planes_z_m": [0.1],
        "absent_hz": None,
    }
    json.dumps(json_data(whole), allow_nan=False)


def test_numbers_as_keys_lose_no_entry():
    assert json_data({0.1: 1, 314.15926: 2}) == {"0.1": 1, "314.159": 2}
    assert list(json_data({100.0001: 1, 100.00012: 2}).values()) == [1, 2]


def test_complex_numbers_are_real_and_imaginary_parts():
    values = np.array([1.0 + 2.0j, 3.0 - 4.0j])
    assert json_data(Shape(values, values)) == {
        "response_m_per_N": {"real": [1.0, 3.0], "imaginary": [2.0, -4.0]},
        "pairs": [[1.0, 2.0], [3.0, -4.0]],
    }


def test_unknown_units_and_types_are_refused():
    with raises_naming(ValueError, "pressure", "'Pa'"):
        json_data(Unknown(1.0))
    with raises_naming(TypeError, "object", "JSON"):
        json_data([object()])
