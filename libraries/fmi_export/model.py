"""Models and instances: a model is an interface and two kernels on flat arrays; an instance has the arrays.

An instance checks its arrays and takes steps. Unit tests use instances directly, whereas hosts use the FMI slave.
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
from fmi_export.model_kernels import compile_model
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
    """The definition of an FMU: its variables, kernels, array sizes, texts of faults, and packages.

    Parameters
    ----------
    name, description
        Model identifier of the FMU, and a short description of the model.
    interface
        The variable table. Its last output is `fault_code`.
    initialise
        Kernel `(constants, parameters, inputs, state, work, outputs) -> fault`, which computes the state at the start.
    step
        Kernel `(constants, parameters, inputs, state, work, outputs, time, step_size) -> fault`, which takes a step.
    n_state, n_work
        Sizes of the state and of the scratch array, both float64. A size that depends on the constants is given as a
        function of these.
    faults
        Text for each fault code of the kernels. In a text, `{name}` is replaced by the value of that variable, and
        `{step_size}` by the communication step (s). The values of outputs are those from the call that returned the
        fault.
    packages
        Names of the packages that the kernels need, which are included in the FMU. The first package contains the
        script that PythonFMU loads, `<name>_fmu.py`.
    step_size, variable_step
        Usual communication step (s), and whether it may change from step to step.
    layout
        Data, as JSON types, from which the model's package makes the interface; empty if the interface is always the
        same. The kernels do not depend on the layout, because sizes that vary are among the constants.
    linear_state
        Function that returns the linear part of the state, given the constants; None if that part is unknown.
    author
        Author of the model; may be empty.
    parts, wiring
        For an assembly: its components, whose kernels are called instead of its own, and their wiring.

    Matrices and tables, which any library may compute, are passed to the kernels as `constants`. This flat array is
    computed when the FMU is built, and stored in the FMU. A kernel writes every output in every call that returns 0; a
    step in which no output changes may return `UNCHANGED` instead. A saved state consists of parameters, inputs,
    outputs and state. It does not include `work`, which is only a cache that a kernel must validate.
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
            raise ValueError(
                f"{self.name}: {len(self.parts)} components are not allowed; there must be <= {MOST_PARTS}"
            )

    @property
    def compiled(self) -> tuple[Model, ...]:
        """The models whose kernels the FMU calls: those of its parts, sorted by name; this model if it has no parts."""
        models = {part.model.name: part.model for part in self.parts}
        return tuple(models[name] for name in sorted(models)) or (self,)


@dataclass(frozen=True, eq=False)
class AssembledModel:
    """A model in an assembly: its name, its constants, and the number of communication steps per step of the model."""

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
        Position of the source for each input of the parts, part by part. The inputs of the assembly are counted first,
        then its outputs: the outputs of all parts in order, without fault codes.
    ramps
        Pairs of positions: an input of the assembly, and the input that contains the slope of the first over a step.
    gathered
        Outputs that describe a whole step, each with an index in `GATHERED`. The index selects the rule that combines
        the values if the step is divided.
    sample_time
        Time between the instants that divide steps (s), or the name of the parameter that contains it.
    jacobi
        Whether all parts use the outputs from the beginning of a step instead of the latest outputs.
    """

    sources: tuple[int, ...]
    ramps: tuple[tuple[int, int], ...]
    gathered: tuple[tuple[int, int], ...]
    sample_time: str | float
    jacobi: bool = False


def with_starts(model: Model, starts: Mapping[str, float], step_size: float | None = None) -> Model:
    """Return a model with different start values of parameters and inputs, and another usual communication step (s).

    Raises
    ------
    ValueError
        If a name is not that of a parameter or input, or if a value is out of range.
    """
    unknown = set(starts) - {v.name for v in model.interface.variables if v.causality != "output"}
    if unknown:
        raise ValueError(f"{model.name} has no parameters or inputs {', '.join(sorted(unknown))}")
    variables = tuple(replace(v, start=starts.get(v.name, v.start)) for v in model.interface.variables)
    return replace(model, interface=Interface(variables), step_size=step_size or model.step_size)


@kernel
def first_outside(values: Array, minimum: Array, maximum: Array, stop: int) -> int:
    """Return the index of the first of `values[:stop]` that is NaN or outside [minimum, maximum], or -1 if none is."""
    for i in range(stop):
        if not (minimum[i] <= values[i] <= maximum[i]):
            return i
    return -1


class Fault(ValueError):
    """Raised when a model stops because of a fault; `code` is the model's `fault_code`."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


class Instance:
    """A running model: parameters, inputs, outputs, state and scratch as flat arrays.

    After a fault, the outputs keep their last valid values. The fault remains until the instance is initialised again;
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
        """Compute the initial state and outputs from parameters and inputs; raise `Fault` if this fails."""
        self.fault = 0
        self._check_inputs()
        compile_model(self.model.initialise, self.model.step)
        self.state[:] = 0.0
        self._next_outputs[:-1] = np.nan  # so that an output that the kernel does not write is an error
        self._finish(self.model.initialise(*self._arrays))

    def step(self, time: float, step_size: float) -> None:
        """Advance the state from `time` by `step_size` (s) under constant inputs; raise `Fault` if this fails."""
        if self.fault:
            raise Fault(self.fault, f"stopped by an earlier fault: {self.message}")
        if not (0.0 < step_size < np.inf):
            raise self.stop(FAULT_STEP_SIZE, f"step size = {step_size:g} s is not allowed; it must be > 0 s and finite")
        self._check_inputs()
        self._step_size = float(step_size)
        # With an int numba would compile another signature.
        self._finish(self.model.step(*self._arrays, float(time), self._step_size))

    def stop(self, code: int, message: str = "") -> Fault:
        """Store a fault until the next initialisation, and return the exception to be raised."""
        self.fault = code
        self.message = message or self.explain(code)
        self.outputs[-1] = code
        return Fault(code, self.message)

    def explain(self, code: int) -> str:
        """Return the text of a fault code, including the invalid value if there is one."""
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
        """Return the value of a variable named in the text of a fault; for an output, the value from the kernel."""
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
