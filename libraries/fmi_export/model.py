"""A model: an interface and two kernels on flat arrays. An instance: its arrays, checked and stepped.

Unit tests use it directly, and the FMI slave wraps it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmi_export.interface import Interface
from fmi_export.jit import kernel
from fmi_export.linear_state import LinearState
from fmi_export.variables import FAULT_CODE, filled

Array = NDArray[np.float64]
InitialiseKernel = Callable[[Array, Array, Array, Array, Array, Array], int]
StepKernel = Callable[[Array, Array, Array, Array, Array, Array, float, float], int]
Size = int | Callable[[Array], int]

UNCHANGED = -1  # returned by a step without fault that leaves all outputs unchanged
GATHERED = ("largest", "sum", "mean")  # over a step; as in `building/native/assembly.c`
MOST_PARTS = 8  # of an assembly, limited by the fault codes; as in `building/native/data.h`
STEP_SIZE = "step_size"  # name of the communication step in the text of a fault

# Faults that every model shares; those of a model are 1 to 99.
FAULT_STEP_SIZE = 999
FAULT_RANGE = 1000  # plus the value reference of the variable that left its range
FAULT_NOT_FINITE = 100_000  # plus the value reference of the output that left its range or is not finite


@dataclass(frozen=True)
class Model:
    """The parts of an FMU.

    Parameters
    ----------
    name, description
        Model identifier of the FMU, and its short description.
    interface
        The variable table. Its last output is `fault_code`.
    initialise
        Kernel `(constants, parameters, inputs, state, work, outputs) -> fault`: the state at the start.
    step
        Kernel `(constants, parameters, inputs, state, work, outputs, time, step_size) -> fault`.
    n_state, n_work
        Sizes of the state and of the scratch array, both float64; functions where they depend on the constants.
    faults
        Text for each fault code of the kernels; `{name}` in it is replaced by that variable's value, and `{step_size}`
        by the communication step (s). Outputs in it show the values of the call that returned the fault.
    packages
        Names of the packages that the kernels need; they are included in the FMU. The first one contains the script
        that PythonFMU loads, `<name>_fmu.py`.
    step_size, variable_step
        Usual communication step (s), and whether it may change from step to step.
    layout
        Data from which the model's package makes its interface, as JSON types; empty if that is always the same. The
        kernels do not depend on it: sizes that vary are among the constants.
    linear_state
        Function that returns the linear part of the state of a model with these constants; None if it is unknown.
    author
        Author of the model; may be empty.
    parts, wiring
        For an assembly: its components, whose kernels are called instead of its own, and their wiring.

    Matrices and tables, computed by any library, are passed to the kernels as `constants`, a flat array that is
    computed when the FMU is built, and stored in the FMU. A kernel writes every output on every call that returns 0; a
    step in which no output changes may return `UNCHANGED` instead. A saved state consists of parameters, inputs,
    outputs and state. `work` is a cache; a kernel revalidates it.
    """

    name: str
    description: str
    interface: Interface
    initialise: InitialiseKernel
    step: StepKernel
    n_state: Size
    n_work: Size
    packages: tuple[str, ...]
    faults: Mapping[int, str] = field(default_factory=dict)
    step_size: float = 250e-6
    variable_step: bool = True
    layout: Mapping[str, Any] = field(default_factory=dict)
    linear_state: Callable[[Array], LinearState] | None = None
    author: str = ""
    parts: tuple[AssembledModel, ...] = ()
    wiring: Wiring | None = None

    def __post_init__(self) -> None:
        if self.interface.variables[-1].name != FAULT_CODE:
            raise ValueError(f"{self.name}: the last output must be {FAULT_CODE}")
        if len(self.parts) > MOST_PARTS:
            raise ValueError(f"{self.name}: {len(self.parts)} components is not allowed; it must be <= {MOST_PARTS}")

    @property
    def compiled(self) -> tuple[Model, ...]:
        """The models whose kernels this model's FMU calls: the models of its parts by name, each once, or itself."""
        models = {part.model.name: part.model for part in self.parts}
        return tuple(models[name] for name in sorted(models)) or (self,)


@dataclass(frozen=True, eq=False)
class AssembledModel:
    """A model in an assembly: its name, its constants, and the number of communication steps in one of its steps."""

    name: str
    model: Model
    constants: Array
    every: int = 1


@dataclass(frozen=True)
class Wiring:
    """Connections and timing of the parts of an assembly; see `building/native/data.h`.

    Parameters
    ----------
    sources
        Position of the source of each input of each part in turn: among the inputs of the assembly, then its outputs,
        which are those of the parts in turn without their fault codes.
    ramps
        Positions of an input of the assembly, and of its slope over a step.
    gathered
        Outputs that cover a whole step, and the position in `GATHERED` of the rule by which the values of the parts of
        that step are combined.
    sample_time
        Parameter of the assembly with the time between the instants that divide steps (s), or that time.
    jacobi
        Whether all parts use the outputs at the beginning of a step, instead of the latest ones.
    """

    sources: tuple[int, ...]
    ramps: tuple[tuple[int, int], ...]
    gathered: tuple[tuple[int, int], ...]
    sample_time: str | float
    jacobi: bool = False


def with_starts(model: Model, starts: Mapping[str, float], step_size: float | None = None) -> Model:
    """Return a model with other start values of parameters and inputs, and another usual communication step (s).

    Raises
    ------
    ValueError
        If no such parameter or input exists, or the value is out of its range.
    """
    unknown = set(starts) - {v.name for v in model.interface.variables if v.causality != "output"}
    if unknown:
        raise ValueError(f"{model.name} has no parameters or inputs {', '.join(sorted(unknown))}")
    variables = tuple(replace(v, start=starts.get(v.name, v.start)) for v in model.interface.variables)
    return replace(model, interface=Interface(variables), step_size=step_size or model.step_size)


@kernel
def first_outside(values: Array, minimum: Array, maximum: Array, stop: int) -> int:
    """Return the index of the first of `values[:stop]` that is outside [minimum, maximum] or not a number, or -1."""
    for i in range(stop):
        if not (minimum[i] <= values[i] <= maximum[i]):
            return i
    return -1


class Fault(ValueError):
    """A model stopped; `code` is its `fault_code`."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


class Instance:
    """A running model: parameters, inputs, outputs, state and scratch as flat arrays.

    A fault leaves the outputs at their last valid values and remains until the instance is initialised again;
    `message` is its text.
    """

    def __init__(self, model: Model, constants: Array) -> None:
        self.model = model
        self.constants = np.ascontiguousarray(constants, dtype=np.float64)
        table = model.interface
        self.values = table.start.copy()
        self.parameters = self.values[: table.n_parameters]
        self.inputs = self.values[table.n_parameters : table.n_parameters + table.n_inputs]
        self.outputs = self.values[table.n_parameters + table.n_inputs :]
        self._next_outputs = self.outputs.copy()
        self.state = self._zeros(model.n_state)
        self.work = self._zeros(model.n_work)
        # Arguments of every step, built once:
        arrays = (self.constants, self.parameters, self.inputs, self.state, self.work, self._next_outputs)
        n_inputs, lowest, highest = table.n_parameters + table.n_inputs, table.minimum, table.maximum
        self._arrays = arrays
        self._inputs_range = (self.values, lowest, highest, n_inputs)
        self._outputs_range = (self._next_outputs, lowest[n_inputs:], highest[n_inputs:], table.n_outputs)
        self._step_size = 0.0
        self.fault = 0
        self.message = ""

    def _zeros(self, size: Size) -> Array:
        return np.zeros(max(size(self.constants) if callable(size) else size, 1))

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.model.interface.position[name]])

    def __setitem__(self, name: str, value: float) -> None:
        self.values[self.model.interface.position[name]] = value

    def initialise(self) -> None:
        """Compute the initial state and outputs from parameters and inputs; raises `Fault`."""
        self.fault = 0
        self._check_inputs()
        self.state[:] = 0.0
        self._next_outputs[:-1] = np.nan  # so that an output that the kernel does not write is an error
        self._finish(self.model.initialise(*self._arrays))

    def step(self, time: float, step_size: float) -> None:
        """Advance the state from `time` by `step_size` (s) under constant inputs; raises `Fault`."""
        if self.fault:
            raise Fault(self.fault, f"stopped by an earlier fault: {self.message}")
        if not (0.0 < step_size < np.inf):
            raise self.stop(FAULT_STEP_SIZE, f"step size = {step_size:g} s is not allowed; it must be > 0 s and finite")
        self._check_inputs()
        self._step_size = float(step_size)
        # With an int numba would compile another signature.
        self._finish(self.model.step(*self._arrays, float(time), self._step_size))

    def stop(self, code: int, message: str = "") -> Fault:
        """Store a fault until the next initialisation, and return the exception to raise for it."""
        self.fault = code
        self.message = message or self.explain(code)
        self.outputs[-1] = code
        return Fault(code, self.message)

    def explain(self, code: int) -> str:
        """Return the text of a fault code, with the invalid value if any."""
        variables = self.model.interface.variables
        if code >= FAULT_NOT_FINITE:
            i = code - FAULT_NOT_FINITE
            value = float(self._next_outputs[i - (len(variables) - len(self.outputs))])
            if np.isfinite(value):
                return variables[i].describe_range(value)
            return f"{variables[i].name} is no longer a finite number"
        if code >= FAULT_RANGE:
            i = code - FAULT_RANGE
            return variables[i].describe_range(float(self.values[i]))
        return filled(self.model.faults.get(code, f"fault {code}"), self._named)

    def _named(self, name: str) -> float:
        """Return the value of a name in the text of a fault; for outputs, the kernel's value."""
        if name == STEP_SIZE:
            return self._step_size
        i = self.model.interface.position[name] - self._inputs_range[3]
        return self[name] if i < 0 else float(self._next_outputs[i])

    def _check_inputs(self) -> None:
        i = first_outside(*self._inputs_range)
        if i >= 0:
            raise self.stop(FAULT_RANGE + i)

    def _finish(self, fault: int) -> None:
        if fault == UNCHANGED:
            return
        if not fault:
            i = first_outside(*self._outputs_range)
            fault = FAULT_NOT_FINITE + self._inputs_range[3] + i if i >= 0 else 0
        if fault:
            raise self.stop(int(fault))
        self.outputs[:] = self._next_outputs
        self.outputs[-1] = 0.0
