"""The floor: the kernels of the three native FMUs in one compiled loop, with the wiring and the events of a run.

There is no FMI in between: what a kernel reads and writes are the arrays of the loop, no value passes through a
function or is checked. The kernels are the very machine code of the native FMUs, so that the two differ by FMI alone.
What the loop computes and records equals the co-simulation in Gauss-Seidel order to the last bit.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import types
from numba.extending import intrinsic

from amb_cosim.cosim.fmus import model_source
from amb_cosim.cosim.schedules import Changes, IntArray, PiecewiseConstant
from amb_cosim.simulation import Prepared
from benchmarks.kernels import step_kernel
from fmi_export.model import Array, Instance


class Stage(NamedTuple):
    """A model in the loop: its inputs `to` take the values `source`, then its kernel is called with `arguments`.

    `arguments` are address and size of its six arrays, after the addresses of the fault and of the exception.
    """

    inputs: Array
    to: IntArray
    source: IntArray
    kernel: int
    arguments: IntArray
    fault: IntArray
    every: int


@dataclass(frozen=True)
class Run:
    """Values recorded from point 0 on, shape (points, variables), and how long (s) its steps took, with recording.

    `parts` holds what of that time went into each model's kernel and into recording, if it was asked for.
    """

    table: Array
    seconds: float
    parts: dict[str, float]


class Floor:
    """A run of the levitated rotor in one loop; it can be run once.

    Parameters
    ----------
    prepared
        What is run: this project's models in Gauss-Seidel order, at constant speed.

    Raises
    ------
    ValueError
        If it is another run, or native FMUs cannot be built here.
    """

    def __init__(self, prepared: Prepared) -> None:
        plan, system = prepared.plan, prepared.plan.system
        order = prepared.scenario.coupling or system.coupling
        if order != "gauss_seidel" or plan.profile or prepared.scenario.fmu or len(system.components) != 3:
            raise ValueError(f"{prepared.name} has no floor; it must run this project's models in Gauss-Seidel order")
        outputs = [f"{c}.{port.name}" for c, i in prepared.interfaces.items() for port in i.of("output")]
        wiring, inputs, _ = system.wiring(prepared.interfaces, list(plan.inputs), outputs)
        names = [*plan.inputs, *outputs]  # each model's outputs in the order in which its kernel writes them
        place = np.array([names.index(name) for name in wiring.names], np.intp)
        self._plan = plan
        self._names = [c.name for c in system.components]
        self._values = np.zeros(len(names))
        self._values[: wiring.n_exogenous] = list(plan.inputs.values())
        self._recorded = np.array([names.index(name) for name in plan.recorded], np.intp)
        events = [(n, names.index(name), value) for n, name, value in plan.events]
        self._changes = PiecewiseConstant(events).changes(0, plan.last + 1)
        self._instances: list[tuple[Instance, Array]] = []
        self._stages: list[Stage] = []
        first = wiring.n_exogenous
        for component, source in zip(system.components, wiring.sources, strict=True):
            instance = Instance(*model_source(component.fmu))
            for name, value in plan.parameters[component.name].items():
                instance[name] = value
            table, own = instance.model.interface, self._values[first : first + len(instance.outputs)]
            to = np.array([table.position[name] - table.n_parameters for name in inputs[component.name]], np.intp)
            self._instances.append((instance, own))
            self._stages.append(_stage(instance, own, to, place[source], step_kernel(component.fmu), component.every))
            first += len(own)
        self._initialise()

    def _initialise(self) -> None:
        """Start all models, carrying outputs along the connections until none changes."""
        before = np.full_like(self._values, np.nan)
        while not np.array_equal(before, self._values):
            before[:] = self._values
            for (instance, own), stage in zip(self._instances, self._stages, strict=True):
                stage.inputs[stage.to] = self._values[stage.source]
                instance.initialise()
                own[:] = instance.outputs

    def run(self, profile: bool = False) -> Run:
        """Settle, then step to the end and record; with `profile`, find out which part takes how long.

        Raises
        ------
        RuntimeError
            If a kernel reports a fault.
        """
        plan, parts = self._plan, (*self._names, "recording")
        table, ticks = np.zeros((plan.last + 1, len(self._recorded))), np.zeros(len(parts), np.int64)
        stages = tuple(self._stages)

        def advance(begin: int, end: int) -> int:
            counted = ticks if profile else None
            arrays = (self._values, self._changes, self._recorded, table)
            return _advance(stages, *arrays, counted, begin, end, plan.step_size)

        fault = advance(plan.first, 0)
        ticks[:] = 0
        begin, first_tick = time.perf_counter(), _now()
        fault = fault or advance(0, plan.last)
        seconds, all_ticks = time.perf_counter() - begin, _now() - first_tick
        if fault:
            raise RuntimeError(f"a kernel ended the loop with fault {fault}")
        shares = (ticks * (seconds / all_ticks)).tolist() if profile else []
        return Run(table, seconds, dict(zip(parts, shares, strict=False)))


def _stage(instance: Instance, outputs: Array, to: IntArray, source: IntArray, kernel: int, every: int) -> Stage:
    fault = np.zeros(2, np.intp)  # and the exception
    addresses = [fault.ctypes.data, fault.ctypes.data + fault.itemsize]
    for array in (
        instance.constants,
        instance.parameters,
        instance.inputs,
        instance.state,
        instance.work,
        outputs,
    ):
        addresses += [array.ctypes.data, len(array)]
    return Stage(instance.inputs, to, source, kernel, np.array(addresses, np.intp), fault, every)


# From here on: machine code.

_OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
_N_ARGUMENTS = 14

F = TypeVar("F", bound=Callable[..., Any])


def _compiled(function: F) -> F:
    return cast(F, numba.njit(**_OPTIONS)(function))


def _emit_cycles(_: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        counter = builder.module.declare_intrinsic("llvm.readcyclecounter", fnty=ir.FunctionType(ir.IntType(64), []))
        return builder.call(counter, [])

    return types.int64(), emit


def _emit_call(_: Any, function: Any, arguments: Any, time: Any, step_size: Any) -> Any:
    """Signature and body of a call of the kernel at an address, whose arguments stand at another."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        word, real = ir.IntType(64), ir.DoubleType()
        given = builder.inttoptr(values[1], word.as_pointer())
        loaded = [builder.load(builder.gep(given, [ir.Constant(word, k)])) for k in range(_N_ARGUMENTS)]
        function = ir.FunctionType(ir.IntType(32), [word] * _N_ARGUMENTS + [real, real])
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), [*loaded, *values[2:]])

    return types.int32(types.intp, types.intp, types.float64, types.float64), emit


_cycles: Any = intrinsic(_emit_cycles)
_call: Any = intrinsic(_emit_call)


@_compiled
def _now() -> int:
    return _cycles()


@_compiled
def _step(stage: Stage, values: Array, n: int, h: float) -> int:
    """One step of a model from point n; its fault, or 0."""
    for k in range(len(stage.to)):
        stage.inputs[stage.to[k]] = values[stage.source[k]]
    if _call(stage.kernel, stage.arguments.ctypes.data, n * h, stage.every * h) != 0:
        return -1
    return stage.fault[0]


@_compiled
def _record(values: Array, recorded: IntArray, row: Array) -> None:
    for k in range(len(recorded)):
        row[k] = values[recorded[k]]


@_compiled
def _advance(
    stages: tuple[Stage, ...],
    values: Array,
    changes: Changes,
    recorded: IntArray,
    table: Array,
    ticks: Any,
    begin: int,
    end: int,
    h: float,
) -> int:
    """Steps from point `begin` to point `end`, recording points from 0 on; the fault that ended it, or 0.

    `ticks` collects processor cycles of the models and of recording, unless it is None.
    """
    change, before, now = 0, 0, 0
    for n in range(begin, end + 1):
        while change < len(changes.points) and changes.points[change] <= n:
            values[changes.positions[change]] = changes.values[change]
            change += 1
        if ticks is not None:
            before = _cycles()
        if n >= 0:
            _record(values, recorded, table[n])
        if ticks is not None:
            now = _cycles()
            ticks[3] += now - before
        if n == end:
            break
        for k, stage in enumerate(stages):
            if n % stage.every == 0:
                fault = _step(stage, values, n, h)
                if fault != 0:
                    return fault
            if ticks is not None:
                before, now = now, _cycles()
                ticks[k] += now - before
    return 0
