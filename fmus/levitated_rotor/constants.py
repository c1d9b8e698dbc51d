"""The constants of an assembly: the plan of its arrays, and the constants of its parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from fmi_export.model import Array, Size
from fmi_export.variables import Variable
from levitated_rotor.assembly import Assembly
from levitated_rotor.faults import input_codes
from levitated_rotor.records import HEAD, N_HEAD, N_PART, N_PARTS, PART

IMPULSE = "N.s"  # unit of outputs that are sums over a step

Links = list[tuple[int, int]]


def constants_of(assembly: Assembly, constants: Sequence[Array]) -> Array:
    """Return the constants of an assembly of parts with these constants, laid out as in `records`.

    Raises
    ------
    ValueError
        If there are more inputs of parts that can leave their range than fault codes.
    """
    given, ramped = _given(assembly), assembly.speed_inputs
    connections = [_connections(assembly, k) for k in range(N_PARTS)]
    outputs = list(assembly.outputs.values())
    flags = [k for k, v in enumerate(outputs) if v.warning]
    sums = [k for k, v in enumerate(outputs) if v.unit == IMPULSE]
    codes = input_codes(assembly)
    tables = _padded(
        np.array([*given, *(link for links in connections for link in links)], np.float64).ravel(),
        np.array([*flags, *sums], np.float64),
        *_ranges(assembly.part_inputs.values()),
        np.array([codes.get(name, 0) for name in assembly.part_inputs], np.float64),
        *_ranges(outputs),
    )
    places, ends = _places(assembly, constants, N_HEAD + N_PARTS * N_PART + len(tables))
    n_links = [len(links) for links in connections]
    parts = [(*place, sum(n_links[:k]), n_links[k]) for k, place in enumerate(places)]
    head = (
        ends["state"] + ends["held"] + len(assembly.parts[0].of("output")),
        ends["work"] + len(flags) + len(sums),
        ends["held"],
        ends["outputs"],
        ends["state"],
        assembly.parts[0].model.interface.parameter_index("sample_time"),
        ends["work"],
        len(given),
        len(ramped),
        list(assembly.inputs).index(assembly.slope) if ramped else -1,
        sum(n_links),
        len(flags),
        len(sums),
    )
    records = (np.array([head], HEAD), np.array(parts, PART))
    return np.concatenate([*(r.view(np.float64) for r in records), tables, *(_padded(own) for own in constants)])


def _given(assembly: Assembly) -> Links:
    """Return the links from inputs of the assembly; those that follow the speed are the last."""
    last = assembly.speed_inputs
    source, target = (_numbers(names) for names in (assembly.inputs, assembly.part_inputs))
    fed = [name for name in assembly.part_inputs if name not in assembly.connections]
    return [(source[assembly.sources[name]], target[name]) for name in sorted(fed, key=lambda name: name in last)]


def _connections(assembly: Assembly, k: int) -> Links:
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


def _ranges(variables: Iterable[Variable]) -> tuple[Array, Array]:
    limits = np.array([(v.minimum, v.maximum) for v in variables], np.float64)
    return limits[:, 0], limits[:, 1]


def _numbers(names: Iterable[str]) -> dict[str, int]:
    return {name: k for k, name in enumerate(names)}


def _size(size: Size, constants: Array) -> int:
    return max(size(constants) if callable(size) else size, 1)


def _even(size: int) -> int:
    return size + size % 2


def _padded(*arrays: Array) -> Array:
    """Return arrays one after another, of even length."""
    joined = np.concatenate(arrays)
    return np.concatenate([joined, np.zeros(len(joined) % 2)])
