"""The constants of an assembly: the plan of its arrays, and the constants of its parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from fmi_export.model import Array, Size
from levitated_rotor.assembly import Assembly
from levitated_rotor.faults import input_codes
from levitated_rotor.records import HEAD, N_HEAD, N_PART, N_PARTS, PART

IMPULSE = "N.s"  # unit of outputs that are sums over a step

Numbers = list[tuple[float, ...]]


def constants_of(assembly: Assembly, constants: Sequence[Array]) -> Array:
    """Return the constants of an assembly of parts with these constants, laid out as in `records`.

    Raises
    ------
    ValueError
        If there are more connections than fault codes.
    """
    given, ramped = _given(assembly), _ramped(assembly)
    connections, watched = ([table(assembly, k) for k in range(N_PARTS)] for table in (_connections, _watched))
    outputs = list(assembly.outputs.values())
    flags = [k for k, v in enumerate(outputs) if v.warning]
    sums = [k for k, v in enumerate(outputs) if v.unit == IMPULSE]
    limits = [v.minimum for v in outputs], [v.maximum for v in outputs]
    rows = [row for table in (given, ramped, *connections, *watched) for row in table]
    tables = _padded(np.array([number for row in (*rows, flags, sums, *limits) for number in row], np.float64))
    places, ends = _places(assembly, constants, N_HEAD + N_PARTS * N_PART + len(tables))
    parts = [
        (*place, *_span([len(own) for own in connections], k), *_span([len(own) for own in watched], k))
        for k, place in enumerate(places)
    ]
    head = (
        ends["state"] + ends["held"] + len(assembly.parts[0].of("output")),
        ends["work"] + len(flags) + len(sums),
        ends["held"],
        ends["outputs"],
        ends["state"],
        ends["work"],
        assembly.parts[0].model.interface.index("parameter", "sample_time"),
        list(assembly.inputs).index(assembly.slope) if ramped else -1,
        len(given),
        len(ramped),
        sum(len(own) for own in connections),
        sum(len(own) for own in watched),
        len(flags),
        len(sums),
    )
    records = (np.array([head], HEAD), np.array(parts, PART))
    return np.concatenate([*(r.view(np.float64) for r in records), tables, *(_padded(own) for own in constants)])


def _given(assembly: Assembly) -> Numbers:
    """Return the inputs of the assembly that stay as they are during a step, as runs of links."""
    source, target = (_numbers(names) for names in (assembly.inputs, assembly.part_inputs))
    within = {*assembly.connections, *assembly.speed_inputs}
    runs: list[list[int]] = []
    for name in assembly.part_inputs:
        if name in within:
            continue
        at, to = source[assembly.sources[name]], target[name]
        if runs and [at, to] == [runs[-1][0] + runs[-1][2], runs[-1][1] + runs[-1][2]]:
            runs[-1][2] += 1
        else:
            runs.append([at, to, 1])
    return [tuple(run) for run in runs]


def _ramped(assembly: Assembly) -> Numbers:
    """Return the links to what follows the speed within a step."""
    source, target = (_numbers(names) for names in (assembly.inputs, assembly.part_inputs))
    return [(source[assembly.sources[name]], target[name]) for name in assembly.speed_inputs]


def _watched(assembly: Assembly, k: int) -> Numbers:
    """Return the watched inputs of part k with their ranges and fault codes."""
    codes, target = input_codes(assembly), _numbers(assembly.part_inputs)
    own = assembly.parts[k].of("input")
    return [(target[name], v.minimum, v.maximum, codes[name]) for name, v in own if name in codes]


def _span(sizes: Sequence[int], k: int) -> tuple[int, int]:
    """Return the first number of table k of several that follow one another, and how many it has."""
    return sum(sizes[:k]), sizes[k]


def _connections(assembly: Assembly, k: int) -> Numbers:
    """Return the links from outputs of part k."""
    source, target = (_numbers(names) for names in (assembly.outputs, assembly.part_inputs))
    own = {name for name, _ in assembly.parts[k].of("output")}
    return [(source[output], target[name]) for name, output in assembly.connections.items() if output in own]


def _places(assembly: Assembly, constants: Sequence[Array], first: int) -> tuple[list[list[int]], dict[str, int]]:
    """Return first place and size of each array of each part, as in `PART`, and all ends; constants from `first`."""
    ends = {"constants": first, "parameters": 0, "held": 0, "state": 0, "work": 0, "outputs": 0}
    places = []
    for part, own in zip(assembly.parts, constants, strict=True):
        sizes = {
            "constants": len(own),
            "parameters": len(part.of("parameter")),
            "held": len(part.of("input")),
            "state": _size(part.model.n_state, own),
            "work": _size(part.model.n_work, own),
            "outputs": len(part.of("output")),
        }
        places.append([number for array, size in sizes.items() for number in (ends[array], size)])
        for array, size in sizes.items():
            ends[array] += _even(size) if array in ("constants", "state", "work") else size
    return places, ends


def _numbers(names: Iterable[str]) -> dict[str, int]:
    return {name: k for k, name in enumerate(names)}


def _size(size: Size, constants: Array) -> int:
    return max(size(constants) if callable(size) else size, 1)


def _even(size: int) -> int:
    return size + size % 2


def _padded(array: Array) -> Array:
    """Return an array of even length, with a zero at its end if need be."""
    return np.concatenate([array, np.zeros(len(array) % 2)])
