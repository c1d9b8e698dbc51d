"""The assembled FMU instead of the three components of a scenario, under two hosts."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from raw import Library, Slave

from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.recording import Recording
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.system import Component, Connection, Signal, System

RIG = "rig"  # name of the component
T = 250e-6  # s, sample time of the controller

Series = dict[str, NDArray[np.float64]]


def separate(prepared: Plan, record_every: int = 1) -> Recording:
    """Run a scenario with its three FMUs; every output is recorded, from the beginning of settling on."""
    outputs = outputs_of(prepared)
    plan = replace(prepared, recorded=outputs, stops=(), record_every=record_every, record_from=-(10**9))
    return execute_plan(plan)


def outputs_of(prepared: Plan) -> tuple[str, ...]:
    """Return the names of all outputs but the fault codes."""
    names = (f"{c}.{p.name}" for c, interface in prepared.interfaces.items() for p in interface.of("output"))
    return tuple(name for name in names if not name.endswith(".fault_code"))


def in_one(plan: Plan, fmu: Path, beside: Mapping[str, Path] | None = None, **changes: Any) -> Recording:
    """Run the same with the assembled FMU: signals, events and ramps get its names, parameters are its start values.

    The angle at the start follows from the settling cycles of the run, which may be others than those of the FMU.
    `beside` are other FMUs of the system, whose input `u` is fed a voltage; `changes` are of the system.
    """
    others = beside or {}
    system = System(
        name="one",
        description="",
        components=(*(Component(name, str(path)) for name, path in others.items()), Component(RIG, str(fmu))),
        connections=tuple(Connection(f"{RIG}.amb_actuator.mb1.v_upper_x", f"{name}.u") for name in others),
        signals=tuple(Signal(signal.name, (f"{RIG}.{signal.name}",)) for signal in plan.system.signals),
    )
    system = replace(system, **changes)
    signals = {signal.name for signal in system.signals}

    def named(name: str) -> str:
        return name if name in signals else f"{RIG}.{name}"

    local = replace(
        plan,
        assembly=assemble(system),
        system=system,
        parameters={component.name: {} for component in system.components} | {RIG: start_angle(plan)},
        inputs={named(name): value for name, value in plan.inputs.items()},
        events=tuple((n, named(name), value) for n, name, value in plan.events),
        ramps=tuple(
            replace(ramp, variable=named(ramp.variable), slope=None if ramp.slope is None else named(ramp.slope))
            for ramp in plan.ramps
        ),
        recorded=tuple(f"{RIG}.{name}" for name in outputs_of(plan)),
        stops=(),
        record_from=-(10**9),
    )
    return execute_plan(local)


def start_angle(plan: Plan) -> dict[str, float]:
    """Return the rotor angle at the start (rad), by its name in the assembled FMU."""
    defaults = {"rotor_contact": 0.0} if "rotor_contact" in plan.parameters else {}
    angles = {name: values["initial.angle"] for name, values in plan.parameters.items() if "initial.angle" in values}
    return {f"{name}.initial.angle": angle for name, angle in (defaults | angles).items()}


def series(recording: Recording) -> Series:
    """Return the recorded outputs by their names in the scenario."""
    names = (name.removeprefix(f"{RIG}.") for name in recording.plan.recorded)
    return dict(zip(names, recording.recorder.table.T, strict=True))


def differing(ours: Series, theirs: Series) -> list[str]:
    """Return the outputs that differ in any bit; both must have the same names and points."""
    assert ours.keys() == theirs.keys()
    assert len(ours) > 100
    for name, values in ours.items():
        assert len(values) == len(theirs[name]) > 30, name
    return [name for name, values in ours.items() if not np.array_equal(values, theirs[name])]


class Host:
    """A host that makes the calls itself: logging off, inputs by name, all outputs at once."""

    def __init__(self, folder: Path, logging: int = 0) -> None:
        self.slave: Slave = Library(folder).instantiate(logging=logging)
        ports = read_interface(folder, "host").ports
        self.outputs = [p for p in ports.values() if p.causality == "output" and p.name != "fault_code"]
        self._kinds = [
            _Kind(kind, [p for p in self.outputs if p.type == kind]) for kind in ("Real", "Integer", "Boolean")
        ]

    def begin(self, start: float = 0.0, **values: float) -> Host:
        slave = self.slave
        calls = [slave.set(**values), slave.setup(start), slave.call("EnterInitializationMode")]
        assert [*calls, slave.call("ExitInitializationMode")] == [0, 0, 0, 0], slave.log
        return self

    def set(self, values: Mapping[str, float]) -> None:
        assert self.slave.set(**{name.replace(".", "__"): value for name, value in values.items()}) == 0, self.slave.log

    def step(self, time: float, step_size: float) -> int:
        return self.slave.call("DoStep", ctypes.c_double(time), ctypes.c_double(step_size), 1)

    def read(self) -> dict[str, float]:
        return {name: value for kind in self._kinds for name, value in kind.read(self.slave)}


class _Kind:
    def __init__(self, kind: str, ports: list[Any]) -> None:
        self.kind, self.names = kind, [port.name for port in ports]
        self.references = (ctypes.c_uint * len(ports))(*[port.reference for port in ports])
        self.values = ((ctypes.c_double if kind == "Real" else ctypes.c_int) * len(ports))()

    def read(self, slave: Slave) -> Iterable[tuple[str, float]]:
        status = slave.call(f"Get{self.kind}", self.references, ctypes.c_size_t(len(self.names)), self.values)
        assert status == 0, slave.log
        return zip(self.names, (float(value) for value in self.values), strict=True)


def inputs_at(plan: Plan, first: int, last: int) -> dict[int, dict[str, float]]:
    """Return the events of a plan from point `first` to `last`: names and values by point."""
    changes: dict[int, dict[str, float]] = {}
    for n, name, value in sorted(plan.events):
        if first <= n <= last:
            changes.setdefault(n, {})[name] = value
    return changes
