"""Measured data in Universal File Format, read by pyuff: functions at nodes (sets 58 and 58b) and modes (set 55).

A channel is named by its node and direction, for example `3.x`. Data in direction -x are read as data along x with the
opposite sign. Instruments without geometry write node 0 for every point. Functions of node 0 whose lines of text differ
are different points, which are numbered, for example `0 (1)` and `0 (2)`; those whose lines agree are repetitions.

Units are taken from the axis labels. If there is no label, the numbers are divided by the factors of the preceding set
164 or, if no set 164 precedes them, of the first set 164 in the file,

    SI = value/(length^a force^b)                                                                  (1)

where the exponents a and b depend on the type of data, for example 1 and 0 for a displacement. If there is no set 164,
the numbers are taken to be in SI units. A label that contradicts the type of data or set 164 is refused, because either
the label or the data that it contradicts may be wrong by a factor of 1000 or more.

The damping ratio zeta of a mode in a set 55 is viscous, or is half of a hysteretic loss factor, zeta = eta/2, which
gives a resonance of the same height. Definitions of the sets: Structural Dynamics Research Laboratory, University of
Cincinnati.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amb_analysis.measured.records import (
    Channel,
    FrequencyResponse,
    Measurement,
    Modes,
    TimeRecord,
    response_above_zero,
)
from amb_analysis.measured.uff_lines import unpadded
from amb_analysis.measured.units import StatedUnits, even_step, factor_to, si_unit, split_quotient
from amb_files.temporary_folders import temporary_folder
from array_types import Array
from fmi_export.building.extras import require_extra

READ = (55, 58, 164)  # types of sets; others may have any content
TIME, RESPONSE, COHERENCE = 1, 4, 6  # types of function
REAL = (2, 4)  # types of numbers
DIRECTIONS = {1: "x", 2: "y", 3: "z"}
PERCENT = 0.01
LENGTH, FORCE = "length", "force"  # of set 164
SI_BY_TYPE = {8: ("m", LENGTH), 11: ("m/s", LENGTH), 12: ("m/s2", LENGTH), 9: ("N", FORCE), 13: ("N", FORCE)}
ABSCISSAS = {"s": {0: "s", 1: "s", 17: "s"}, "Hz": {0: "Hz", 1: "Hz", 18: "Hz", 19: "rpm"}}  # units by type of data
RPM = 19
NO_LABEL = ("", "NONE")
TEXTS = ("id1", "id2", "id4", "id5")  # lines of text of a function, without its date
NO_REFERENCE = ("", 0, 0)  # name, node and direction of the input of a coherence with all inputs
MOST_LISTED = 6  # points without a place
MOST_FILLING = 5  # zeros at the end of a line of six numbers
BYTE_ORDERS, IEEE = (1, 2), 2  # of binary sets: little and big endian; formats 1 and 3 are of VAX and IBM
WIDEST = 1e60  # largest over smallest magnitude of a set's numbers: of a wrong byte order they are random
SAME_FREQUENCIES = 1e-6  # relative difference between a coherence and its response
SAME_UNIT = 1e-3  # relative difference between a label and a factor of set 164, which may have four digits
SAME_DAMPING = 0.1  # relative difference between a damping ratio and half of a loss factor

Set = Mapping[str, Any]


def read_uff(path: Path, units: StatedUnits, places: Container[str] = ()) -> Measurement | TimeRecord:
    """Return the frequency responses with coherence and the modes of a file, or its time record.

    Parameters
    ----------
    path
        The file.
    units
        Units that the user states for `frequency`, `time`, a response such as `3.x/7.x`, or a channel of a record such
        as `3.x`.
    places
        Names of the channels whose place the user states, such as `0 (1)`.

    Raises
    ------
    ValueError
        If the file cannot be read, if pyuff is not installed, if a unit, direction or damping is not allowed, or if the
        place of a numbered point is not stated.
    """
    require_extra("measured", "a UFF file", "pyuff")
    try:
        sets = _sets(path)
        _number_points([item for item in sets if item["type"] == 58], places)
        return _content(sets, units)
    except ValueError:
        raise
    except Exception as error:  # pyuff raises plain exceptions, and leaves out what it cannot read
        raise ValueError(f"it cannot be read as UFF: {error or type(error).__name__}") from error


def _content(sets: Sequence[Set], units: StatedUnits) -> Measurement | TimeRecord:
    functions = [item for item in sets if item["type"] == 58]
    responses, warnings = _responses(functions, units)
    if responses:
        return Measurement(responses, _modes(sets), warnings)
    record = [item for item in functions if item["func_type"] == TIME]
    if record:
        return _record(record, units)
    modes = _modes(sets)
    if modes is None:
        raise ValueError("it has no frequency response, time record or mode")
    return Measurement((), modes)


def _sets(path: Path) -> list[dict[str, Any]]:
    """Return the sets of a file; functions include the factors of their set 164, but not padding after their data."""
    import pyuff

    try:
        with temporary_folder() as folder:
            unpadded_path = folder / "unpadded.uff"
            unpadded_path.write_bytes(unpadded(path.read_bytes()))
            file = pyuff.UFF(str(unpadded_path))
            places = [k for k, kind in enumerate(file.get_set_types()) if kind in READ]
            content = file.read_sets(places)
    except Exception as error:  # pyuff raises plain exceptions
        raise ValueError(f"it cannot be read as UFF: {error}") from error
    sets = [dict(item) for item in ([content] if isinstance(content, dict) else content)]
    factors = next((_factors(item) for item in sets if item["type"] == 164), None)
    for place, item in zip(places, sets, strict=True):
        if item["type"] == 164:
            factors = _factors(item)
        elif item["type"] == 58:
            _check_length(item, place + 1)
            n = int(item["num_pts"])
            item |= {"factors": factors, "x": np.asarray(item["x"], np.float64)[:n], "data": item["data"][:n]}
            _check_function(item, place + 1)
    return sets


def _check_length(item: Set, number: int) -> None:
    """Raise ValueError if a function in text form has more numbers than announced; only zeros may pad its last line."""
    n, data = int(item["num_pts"]), item["data"]
    if n < 0 or (not item["binary"] and (len(data) - n > MOST_FILLING or np.any(data[n:] != 0.0))):
        raise ValueError(f"set {number} announces {n} points but contains {len(data)}; it is damaged or incomplete")


def _check_function(item: Set, number: int) -> None:
    """Raise ValueError if the count of a function's numbers is not as announced, or their format is not allowed."""
    if item["binary"] and (item["byte_ordering"] not in BYTE_ORDERS or item["fp_format"] != IEEE):
        raise ValueError(
            f"set {number} states byte order {item['byte_ordering']} and number format {item['fp_format']}; the byte "
            f"order must be 1 or 2, and the format must be {IEEE} (IEEE 754)"
        )
    n, announced = len(item["data"]), int(item["num_pts"])
    if n != announced or len(item["x"]) != n:
        raise ValueError(f"set {number} announces {announced} points but contains {n}; it is damaged or incomplete")
    sizes = np.abs(item["data"])
    sizes = sizes[sizes > 0.0]
    if not np.isfinite(sizes).all() or (len(sizes) and sizes.max() > WIDEST * sizes.min()):
        raise ValueError(
            f"set {number} contains numbers from {sizes.min():.3g} to {sizes.max():.3g}; they are not finite, or their "
            f"byte order is not the stated one"
        )


def _factors(item: Set) -> dict[str, float]:
    """Return the factors of length and force in a set 164."""
    factors = {key: float(item[key]) for key in (LENGTH, FORCE)}
    if not all(np.isfinite(value) and value > 0.0 for value in factors.values()):
        raise ValueError(f"set 164 with the factors {factors} is not allowed; they must be > 0")
    return factors


def _number_points(functions: Sequence[dict[str, Any]], places: Container[str]) -> None:
    """Add a `point` to each function of node 0 without a name, if their lines of text differ.

    The date is left out of the comparison, because it also differs between repetitions. A coherence has other texts
    than its response, so that its point is known only if there is one for each response.
    """
    groups: dict[tuple[Any, ...], dict[tuple[str, ...], list[dict[str, Any]]]] = defaultdict(dict)
    for item in functions:
        if not int(item["rsp_node"]) and not _entity(item, "rsp"):
            texts = tuple(str(item.get(line, "")).strip() for line in TEXTS)
            key = tuple(item[name] for name in ("func_type", "rsp_dir", "ref_node", "ref_dir"))
            groups[key].setdefault(texts, []).append(item)
    lacking: dict[str, str] = {}
    for (kind, *ends), points in groups.items():
        if kind == COHERENCE and len(points) != len(groups.get((RESPONSE, *ends), ())):
            continue
        for number, (texts, items) in enumerate(points.items(), 1):
            for item in items if len(points) > 1 else ():
                item["point"] = number
                if (name := _name(item, "rsp")[0]) not in places:
                    others = [set(column) for column in zip(*points, strict=True)]
                    text = next(text for text, other in zip(texts, others, strict=True) if len(other) > 1)
                    lacking.setdefault(name, text)
    if lacking:
        listed = ", ".join(f"{name} {text!r}" for name, text in [*lacking.items()][:MOST_LISTED])
        first = next(iter(lacking))
        raise ValueError(
            f"{len(lacking)} points have node 0 and no name: {listed}{', ...' if len(lacking) > MOST_LISTED else ''}; "
            f"state the place of each, for example channels={{'{first}': '0.1 m.x'}}"
        )


def _responses(functions: Sequence[Set], units: StatedUnits) -> tuple[tuple[FrequencyResponse, ...], tuple[str, ...]]:
    """Return the responses with their coherence, and a sentence about coherence that belongs to no response."""
    measured, coherences = (
        _by_ends(item for item in functions if item["func_type"] == kind) for kind in (RESPONSE, COHERENCE)
    )
    result, used = {}, set[int]()
    for ends, items in measured.items():
        partners = coherences.get(ends) or coherences.get((*ends[:3], *NO_REFERENCE), [])
        for k, item in enumerate(items):
            partner = partners[k] if len(partners) == len(items) else None
            result[id(item)] = _response(item, partner, units)
            if result[id(item)].coherence is not None:
                used.add(id(partner))
    unused = [item for item in functions if item["func_type"] == COHERENCE and id(item) not in used]
    names = ", ".join(dict.fromkeys(f"{_name(item, 'rsp')[0]}/{_name(item, 'ref')[0]}" for item in unused))
    warnings = (
        (f"the coherence of {names} is not used, because its places or frequencies are those of no response",)
        if unused and result
        else ()
    )
    return tuple(result[id(item)] for item in functions if id(item) in result), warnings


def _by_ends(functions: Any) -> dict[tuple[Any, ...], list[Set]]:
    """Return a list of functions for each output and input; it has several items if the measurement was repeated."""
    result: dict[tuple[Any, ...], list[Set]] = defaultdict(list)
    for item in functions:
        output, source = (
            (_entity(item, end), abs(int(item[f"{end}_node"])), abs(int(item[f"{end}_dir"]))) for end in ("rsp", "ref")
        )
        result[(f"{output[0]} {item.get('point', '')}", *output[1:], *source)].append(item)
    return result


def _entity(item: Set, end: str) -> str:
    """Return the name of a place; an empty text if there is none."""
    entity = str(item[f"{end}_ent_name"]).strip()
    return "" if entity in NO_LABEL else entity


def _response(item: Set, partner: Set | None, units: StatedUnits) -> FrequencyResponse:
    (output_name, output_sign), (input_name, input_sign) = _name(item, "rsp"), _name(item, "ref")
    name = f"{output_name}/{input_name}"
    if item["ord_data_type"] in REAL:
        raise ValueError(f"{name} is real: it contains amplitudes without phases; export it as complex numbers")
    if stated := units.of(name, ""):
        ends = [si_unit(unit, name) for unit in split_quotient(stated, name)]
    else:
        ends = [_unit(item, axis, label, name) for axis, label in _labels(item, name).items()]
    (factor, output_unit), (divisor, input_unit) = ends
    frequencies = _abscissa(item, "frequency", "Hz", units)
    values = np.asarray(item["data"], np.complex128) * (output_sign * factor / (input_sign * divisor))
    gamma = _coherence(partner, item["x"])
    output, source = Channel(output_name, output_unit), Channel(input_name, input_unit)
    return response_above_zero(output, source, frequencies, values, gamma)


def _coherence(item: Set | None, frequencies: Array) -> Array | None:
    """Return the coherence if its frequencies are the same as those of the response, otherwise None."""
    if item is None or len(item["x"]) != len(frequencies):
        return None
    same = np.allclose(item["x"], frequencies, rtol=SAME_FREQUENCIES, atol=0.0)
    scale = PERCENT if _label(item, "ordinate") == "%" else 1.0
    return scale * np.real(item["data"]) if same else None


def _labels(item: Set, name: str) -> dict[str, str]:
    """Return the axis labels of output and input; the output's label may be the quotient of both units, as in `g/N`."""
    above, below = (_label(item, axis) for axis in ("ordinate", "orddenom"))
    if above and not _is_unit(above, name):
        quotient, of_input = split_quotient(above, name)
        if below and si_unit(below, name) != si_unit(of_input, name):
            raise ValueError(
                f"{name}: the labels {above} and {below} contradict each other; state its unit, {_example(name)}"
            )
        above, below = quotient, of_input
    return {"ordinate": above, "orddenom": below}


def _is_unit(label: str, name: str) -> bool:
    try:
        si_unit(label, name)
    except ValueError:
        return False
    return True


def _label(item: Set, axis: str) -> str:
    label = str(item[f"{axis}_axis_units_lab"]).strip()
    return "" if label in NO_LABEL else label


def _unit(item: Set, axis: str, label: str, name: str) -> tuple[float, str]:
    """Return the factor to SI and the SI unit of an axis, from its label, or from (1) and its type of data."""
    kind = int(item[f"{axis}_spec_data_type"])
    si, dimension = SI_BY_TYPE.get(kind, ("", ""))
    factors = item["factors"]
    if not label:
        if not si:
            raise ValueError(
                f"{name}: data of type {kind} without a unit are not allowed; state the unit, {_example(name)}"
            )
        return 1.0 if factors is None else 1.0 / factors[dimension], si
    factor, unit = si_unit(label, name)
    if si and unit != si:
        raise ValueError(
            f"{name}: the label {label!r} contradicts the type of data {kind}, {si}; state its unit, {_example(name)}"
        )
    if si and factors is not None and abs(factor * factors[dimension] - 1.0) > SAME_UNIT:
        raise ValueError(
            f"{name}: the label {label!r} contradicts set 164, whose factor of {dimension} is {factors[dimension]:g}; "
            f"state its unit, {_example(name)}"
        )
    return factor, unit


def _example(name: str) -> str:
    return f"for example channel_units={{'{name}': '{'m/N' if '/' in name else 'm/s2'}'}}"


def _abscissa(item: Set, name: str, target: str, units: StatedUnits) -> Array:
    """Return frequencies (Hz) or times (s), converted from the unit that the label or type of the abscissa states."""
    kind, label = int(item["abscissa_spec_data_type"]), _label(item, "abscissa")
    by_type = ABSCISSAS[target].get(kind)
    if stated := units.of(name, ""):
        return np.asarray(item["x"] * factor_to(target, stated, name))
    if by_type is None:
        raise ValueError(
            f"{name} with data of type {kind} is not allowed; state its unit: channel_units={{'{name}': '{target}'}}"
        )
    factor = factor_to(target, label or by_type, name)
    if kind == RPM and not np.isclose(factor, factor_to(target, by_type, name), rtol=SAME_UNIT):
        raise ValueError(
            f"{name}: the label {label!r} contradicts the type of data {kind}, rpm; state its unit: "
            f"channel_units={{'{name}': '{target}'}}"
        )
    return np.asarray(item["x"] * factor)


def _name(item: Set, end: str) -> tuple[str, float]:
    direction = int(item[f"{end}_dir"])
    entity, node = _entity(item, end), int(item[f"{end}_node"])
    place = entity if not node and entity else str(node)
    point = f" ({item['point']})" if end == "rsp" and "point" in item else ""
    if direction == 0:
        return f"{place}{point}", 1.0
    if abs(direction) not in DIRECTIONS:
        raise ValueError(f"direction {direction} at node {node} is not allowed; rotational channels are not supported")
    return f"{place}.{DIRECTIONS[abs(direction)]}{point}", float(np.sign(direction))


def _record(functions: Sequence[Set], units: StatedUnits) -> TimeRecord:
    """Return the channels over time; repeated records of a channel are concatenated."""
    steps, lengths = (
        {round(even_step(_abscissa(f, "time", "s", units)), 12) for f in functions},
        {len(f["x"]) for f in functions},
    )
    if len(steps) > 1 or len(lengths) > 1:
        raise ValueError("its time records have different times; a record must have a single sample time")
    signals: dict[Channel, list[Array]] = defaultdict(list)
    for item in functions:
        name, sign = _name(item, "rsp")
        stated = units.of(name, "")
        factor, unit = si_unit(stated, name) if stated else _unit(item, "ordinate", _label(item, "ordinate"), name)
        signals[Channel(name, unit)].append(sign * factor * np.real(np.asarray(item["data"])))
    counts = {channel: len(records) for channel, records in signals.items()}
    if len(set(counts.values())) > 1:
        text = ", ".join(f"{channel} {n}" for channel, n in counts.items())
        raise ValueError(f"its channels have different numbers of records, {text}; all must have the same number")
    (repeats,) = set(counts.values())
    return TimeRecord(steps.pop(), {channel: np.concatenate(records) for channel, records in signals.items()}, repeats)


def _modes(sets: Sequence[Set]) -> Modes | None:
    """Return the modes of sets 55: normal modes (type 2) and complex eigenvalues (types 3 and 7)."""
    pairs = []
    for item in sets:
        if item["type"] == 55 and item["analysis_type"] == 2:
            pairs.append((float(item["freq"]), _damping_ratio(item)))
        elif item["type"] == 55 and item["analysis_type"] in (3, 7):
            size = abs(complex(item["eig"]))
            if not size > 0.0:
                raise ValueError(f"mode {item['mode_n']} has the eigenvalue {size:g} rad/s, so it has no frequency")
            pairs.append((abs(complex(item["eig"]).imag) / (2.0 * np.pi), -complex(item["eig"]).real / size))
    if not pairs:
        return None
    frequencies, ratios = np.array(sorted(pairs)).T
    return Modes(frequencies, ratios)


def _damping_ratio(item: Set) -> float:
    """Return the damping ratio of a normal mode, which is viscous or is half of the hysteretic loss factor."""
    viscous, half = float(item["modal_damp_vis"]), 0.5 * float(item["modal_damp_his"])
    if viscous and half and abs(half - viscous) > SAME_DAMPING * abs(viscous):
        raise ValueError(
            f"the mode at {float(item['freq']):g} Hz has a viscous damping ratio of {viscous:g} and a loss factor of "
            f"{2.0 * half:g}; write only one of them, or a loss factor that is twice the ratio"
        )
    return viscous or half
