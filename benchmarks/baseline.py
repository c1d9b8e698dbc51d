"""Run the kernels of the native FMUs in one compiled loop without FMI, with the wiring and the events of a run.

A kernel reads and writes the arrays of the loop directly: no FMI function is called and no value is checked. The
kernels are the machine code of the native FMUs, so the difference in time to a co-simulation is the cost of FMI. Values
and records equal those of the co-simulation in Gauss-Seidel order to the last bit.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from amb_cosim.cosim.fmu.fmus import model_source
from amb_cosim.cosim.grid.schedules import Changes, PiecewiseConstant
from amb_cosim.scenario.plan import ScenarioPlan
from array_types import Array, Indices
from benchmarks.kernels import step_kernel
from fmi_export.model import UNCHANGED, Instance


class KernelCall(NamedTuple):
    """One call of a model's kernel: its inputs `to` take the values `source`, then the kernel steps.

    `kernel` is the address of its machine code, `every` the number of communication steps that its step spans.
    `arguments` are the addresses of the fault code and of the exception, then address and size of the six arrays.
    """

    inputs: Array
    to: Indices
    source: Indices
    kernel: int
    arguments: Indices
    fault: Indices
    every: int


@dataclass(frozen=True)
class BaselineRun:
    """Values recorded from point 0 on, shape (points, variables), and time (s) of the steps, with recording.

    If the run was profiled, `parts` holds the time (s) of each model's kernel and of recording, and `steps` that of all
    models for each communication step.
    """

    table: Array
    seconds: float
    parts: dict[str, float]
    steps: Array


class Baseline:
    """A run of the levitated rotor in one loop without FMI; it can be run once.

    Parameters
    ----------
    prepared
        A run of this project's models in Gauss-Seidel order, at constant speed.

    Raises
    ------
    ValueError
        If the run is of another kind, or the C compiler of native FMUs is missing.
    """

    def __init__(self, plan: ScenarioPlan) -> None:
        system = plan.system
        order = system.coupling
        if order != "gauss_seidel" or plan.profile:
            raise ValueError(f"{plan.name} has no baseline; it must run this project's models in Gauss-Seidel order")
        outputs = [f"{c}.{port.name}" for c, i in plan.interfaces.items() for port in i.of("output")]
        wiring = plan.assembly.wiring(plan.inputs, outputs)
        names = [*plan.inputs, *outputs]  # each model's outputs in the order in which its kernel writes them
        positions = np.array([names.index(name) for name in wiring.names], np.intp)
        self._plan = plan
        self._names = [c.name for c in system.components]
        self._values = np.zeros(len(names))
        self._values[: wiring.n_exogenous] = list(plan.inputs.values())
        self._recorded = np.array([names.index(name) for name in plan.recorded], np.intp)
        events = [(n, names.index(name), value) for n, name, value in plan.events]
        self._changes = PiecewiseConstant(events).changes(0, plan.last + 1)
        self._instances: list[tuple[Instance, Array]] = []  # with their outputs
        self._calls: list[KernelCall] = []
        first = wiring.n_exogenous
        for component, source in zip(system.components, wiring.sources, strict=True):
            instance = Instance(*model_source(component.fmu, **plan.assembly.options))
            for name, value in plan.parameters[component.name].items():
                instance[name] = value
            table, outputs_of_model = instance.model.interface, self._values[first : first + len(instance.outputs)]
            to = np.array(
                [table.position[name] - table.n_parameters for name in wiring.inputs[component.name]], np.intp
            )
            self._instances.append((instance, outputs_of_model))
            self._calls.append(
                _kernel_call(
                    instance, outputs_of_model, to, positions[source], step_kernel(component.fmu), component.every
                )
            )
            first += len(outputs_of_model)
        self._initialise()

    def _initialise(self) -> None:
        """Start all models, carrying outputs along the connections until none changes."""
        before = np.full_like(self._values, np.nan)
        while not np.array_equal(before, self._values):
            before[:] = self._values
            for (instance, outputs), call in zip(self._instances, self._calls, strict=True):
                call.inputs[call.to] = self._values[call.source]
                instance.initialise()
                outputs[:] = instance.outputs

    def run(self, profile: bool = False) -> BaselineRun:
        """Settle, then step to the end and record; with `profile`, also measure the time of each part.

        Raises
        ------
        RuntimeError
            If a kernel reports a fault.
        """
        plan, parts = self._plan, (*self._names, "recording")
        table, ticks = np.zeros((plan.last + 1, len(self._recorded))), np.zeros(len(parts), np.int64)
        step_ticks = np.zeros(plan.last if profile else 0, np.int64)
        calls = tuple(self._calls)

        def advance(begin: int, end: int) -> int:
            counted = ticks if profile else None
            arrays = (self._values, self._changes, self._recorded, table)
            return _advance(calls, *arrays, counted, step_ticks, begin, end, plan.step_size)

        fault = advance(plan.first, 0)
        ticks[:] = 0
        begin, first_tick = time.perf_counter(), _now()
        fault = fault or advance(0, plan.last)
        seconds, all_ticks = time.perf_counter() - begin, _now() - first_tick
        if fault:
            raise RuntimeError(f"a kernel ended the loop with fault {fault}")
        part_seconds = (ticks * (seconds / all_ticks)).tolist() if profile else []
        step_seconds = step_ticks * np.float64(seconds / all_ticks)
        return BaselineRun(table, seconds, dict(zip(parts, part_seconds, strict=False)), step_seconds)


def _kernel_call(
    instance: Instance, outputs: Array, to: Indices, source: Indices, kernel: int, every: int
) -> KernelCall:
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
    return KernelCall(instance.inputs, to, source, kernel, np.array(addresses, np.intp), fault, every)


# The functions below are compiled to machine code.

_OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
_N_ARGUMENTS = 14
EXCEPTION = -2  # returned by a step whose kernel raised an exception

F = TypeVar("F", bound=Callable[..., Any])


def _compiled(function: F) -> F:
    return cast(F, numba.njit(**_OPTIONS)(function))


def _emit_cycles(_: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        counter = builder.module.declare_intrinsic("llvm.readcyclecounter", fnty=ir.FunctionType(ir.IntType(64), []))
        return builder.call(counter, [])

    return types.int64(), emit


def _emit_call(_: Any, function: Any, arguments: Any, time: Any, step_size: Any) -> Any:
    """Return signature and body of a call of the kernel at address `function`, with the arguments at `arguments`."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        word, real = ir.IntType(64), ir.DoubleType()
        addresses = builder.inttoptr(values[1], word.as_pointer())
        loaded = [builder.load(builder.gep(addresses, [ir.Constant(word, k)])) for k in range(_N_ARGUMENTS)]
        function = ir.FunctionType(ir.IntType(32), [word] * _N_ARGUMENTS + [real, real])
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), [*loaded, *values[2:]])

    return types.int32(types.intp, types.intp, types.float64, types.float64), emit


_cycles: Any = intrinsic(_emit_cycles)
_call: Any = intrinsic(_emit_call)


@_compiled
def _now() -> int:
    return _cycles()


@_compiled
def _step(call: KernelCall, values: Array, n: int, h: float) -> int:
    """Step a model from point n; return its fault code, `EXCEPTION`, or 0."""
    for k in range(len(call.to)):
        call.inputs[call.to[k]] = values[call.source[k]]
    if _call(call.kernel, call.arguments.ctypes.data, n * h, call.every * h) != 0:
        return EXCEPTION
    return 0 if call.fault[0] == UNCHANGED else call.fault[0]


@_compiled
def _record(values: Array, recorded: Indices, row: Array) -> None:
    for k in range(len(recorded)):
        row[k] = values[recorded[k]]


@_compiled
def _advance(
    calls: tuple[KernelCall, ...],
    values: Array,
    changes: Changes,
    recorded: Indices,
    table: Array,
    ticks: Any,
    step_ticks: Indices,
    begin: int,
    end: int,
    h: float,
) -> int:
    """Step from point `begin` to point `end`, recording points from 0 on; return the fault that ended it, or 0.

    `ticks` collects processor cycles of each model and of recording, unless it is None; then `step_ticks` has those of
    all models for each step from 0 on.
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
            ticks[len(calls)] += now - before
        if n == end:
            break
        started = now
        for k, call in enumerate(calls):
            if n % call.every == 0:
                fault = _step(call, values, n, h)
                if fault != 0:
                    return fault
            if ticks is not None:
                before, now = now, _cycles()
                ticks[k] += now - before
        if ticks is not None and n >= 0:
            step_ticks[n] = now - started
    return 0
