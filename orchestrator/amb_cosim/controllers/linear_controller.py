"""A linear controller from Python: one sampled law, or one law for each speed, with its signals and demands."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from amb_cosim.controllers.discretisation import check_sample_time, sampled
from amb_cosim.controllers.laws import Law, law_of
from amb_cosim.cosim.choices import Flavour, Fmi
from amb_cosim.cosim.system.values import Raw, plain_number, plain_value, quantity
from amb_files.checks import errors_in
from array_types import Array
from linear_controller.ports import Ports

if TYPE_CHECKING:
    from fmi_export.model import Model

SLOW_TIME = 0.1  # s
STABLE = 1.0 + 1e-9  # largest pole magnitude of a law that counts as stable: integrators are at 1
PARAMETERS = {"gains": ("gain",), "offsets": ("offset",), "limits": ("lower", "upper"), "delay": ("delay",)}
WEIGHTS = (0.25, 0.5, 0.75)  # of the second of two speeds, for interpolated matrices whose poles are checked


@dataclass(frozen=True, eq=False)
class LinearController:
    """One sampled law, or one law per speed, with the data of its FMU; created by `linear_controller`.

    In scenarios and systems, it can take the place of an FMU: `amb_cosim.run(scenario, fmu={"rolac_controller":
    controller})`.

    Parameters
    ----------
    laws
        Sampled laws of the same order by speed (rad/s), ascending.
    ports
        Names of signals and demands.
    sample_time
        Sample time (s).
    slow_time
        Time constant (s) above which a mode counts as slow; see `slow_modes`.
    starts
        Start values of the FMU's parameters, by name.
    allow_unstable
        Whether poles outside the unit circle are allowed.
    """

    model: ClassVar[str] = "linear_controller"  # name of the model whose constants it provides

    laws: Mapping[float, Law]
    ports: Ports
    sample_time: float
    slow_time: float = SLOW_TIME
    starts: Mapping[str, float] = field(default_factory=dict)
    allow_unstable: bool = False

    @cached_property
    def model_and_constants(self) -> tuple[Model, Array]:
        """The model of the controller's FMU, and the constants of this model."""
        from amb_cosim.controllers.constants import constants_of
        from amb_cosim.controllers.slow_modes import slow_modes
        from fmi_export.model import with_starts
        from linear_controller.controller import model_for

        laws = list(self.laws.values())
        modes = [slow_modes(law, self.sample_time, self.slow_time) for law in laws]
        model = with_starts(model_for(self.ports, self.sample_time), self.starts)
        return model, constants_of(list(self.laws), laws, modes)

    def build(
        self,
        folder: str | Path,
        flavour: Flavour = "native",
        platforms: str | Iterable[str] | None = None,
        fmi: Fmi = 2,
    ) -> Path:
        """Write `linear_controller.fmu` into a folder and return its path; the options are as for `amb_cosim.build`."""
        from amb_cosim.cosim.building.build_target import BuildTarget

        return BuildTarget(flavour, platforms, fmi).build(*self.model_and_constants, Path(folder))

    def save(self, path: str | Path) -> Path:
        """Write the controller as plain arrays (`.npz`, `.mat`) that `linear_controller` can read; return the path."""
        from amb_cosim.controllers.array_file import write_arrays

        facts = {
            "Ts": self.sample_time,
            "inputs": self.ports.signals,
            "outputs": self.ports.demands,
            "slow_time": self.slow_time,
            "allow_unstable": float(self.allow_unstable),
            "start_names": list(self.starts),
            "start_values": list(self.starts.values()),
        }
        return write_arrays(Path(path), self.laws, facts)

    def __repr__(self) -> str:
        """Return a text with the size, and a digest of the FMU's interface and constants, by which builds are kept."""
        model, constants = self.model_and_constants
        digest = hashlib.sha256(model.interface.canonical() + constants.tobytes()).hexdigest()[:32]
        states = len(next(iter(self.laws.values())).A)
        sizes = f"signals: {len(self.ports.signals)}, demands: {len(self.ports.demands)}, states: {states}"
        speeds = f", laws at {len(self.laws)} speeds" if len(self.laws) > 1 else ""
        return f"{type(self).__name__}({sizes}, sampled every {self.sample_time:g} s{speeds}; {digest})"

    @property
    def dt(self) -> float:
        """Sample time (s), by the name that it has in python-control."""
        return self.sample_time

    def state_space(self, speed: float | None = None) -> Any:
        """Return `law_at` as a control.StateSpace; dots in names are replaced by underscores."""
        import control

        law = self.law_at(speed)
        ports = {"inputs": self.ports.signals, "outputs": self.ports.demands}
        names = {kind: [name.replace(".", "_") for name in of_kind] for kind, of_kind in ports.items()}
        return control.ss(law.A, law.B, law.C, law.D, self.sample_time, **names)

    def law_at(self, speed: float | None = None) -> Law:
        """Return the sampled law from signals to demands, with the gains of the demands.

        For a table of laws, this is the law at a speed (rad/s), interpolated as in a run, or the first law if no speed
        is given.
        """
        speeds, laws = list(self.laws), list(self.laws.values())
        place = 0.0 if speed is None else float(np.interp(speed, speeds, np.arange(len(speeds))))
        lower, upper = laws[math.floor(place)], laws[math.ceil(place)]
        w = place - math.floor(place)
        A, B, C, D = ((1.0 - w) * getattr(lower, name) + w * getattr(upper, name) for name in "ABCD")
        gains = np.array([[self.starts.get(f"{demand}.gain", 1.0)] for demand in self.ports.demands])
        return Law(A, B, gains * C, gains * D, lower.sample_time)


def linear_controller(
    K: Any,
    inputs: str | Sequence[str] | None = None,
    outputs: str | Sequence[str] | None = None,
    sample_time: Raw | None = None,
    *,
    method: str | None = None,
    prewarp: Raw | None = None,
    sampled_arrays: bool | None = None,
    gains: float | Sequence[float] | None = None,
    offsets: Raw | Sequence[Raw] | None = None,
    limits: tuple[Raw, Raw] | Sequence[tuple[Raw, Raw]] | None = None,
    delay: Raw | None = None,
    slow_time: Raw | None = None,
    allow_unstable: bool | None = None,
) -> LinearController:
    """Return a sampled controller u = K y that can be used in scenarios and built as an FMU.

    For a K designed for negative feedback, u = -K y, pass `-K`. If K is a file, the other arguments replace its values.

    Parameters
    ----------
    K
        A law, which is a control.StateSpace or TransferFunction, a system of scipy.signal, or arrays (A, B, C, D), (z,
        p, k) or (num, den). Alternatively, a dict that maps speeds (rad/s, or texts with a unit) to laws of equal
        order, whose matrices are interpolated, or the path of a file with the arrays A, B, C, D (`.npz`, `.mat`) or
        with blocks (`.toml`).
    inputs, outputs
        Names of the measured signals (m) and of the demands (A), as in the other components; by default the labels of
        K.
    sample_time
        Time between samples, in s or as a text with a unit; by default the sample time of K if K is sampled.
    method, prewarp
        Discretisation of a continuous K: `tustin` (the default, which is exact at the frequency `prewarp` in rad/s if
        this is set), `zoh`, `foh`, `euler`, `backward_diff`, `matched` or `impulse`. Neither can be set for a sampled
        K.
    sampled_arrays
        Whether arrays describe a sampled law. Arrays alone do not state this, whereas a file of arrays does.
    gains, offsets, limits
        Factor (default 1), added value (default 0 A), and smallest and largest value (A, or texts with a unit), for
        each demand or for all demands.
    delay
        Delay of the demands in samples, integer or fractional (default 0), or a time as a text with a unit.
    slow_time
        Time constant (default 0.1 s) above which modes track the limited demand (anti-windup).
    allow_unstable
        Whether the controller itself may have poles outside the unit circle.

    Raises
    ------
    ValueError
        If an argument is invalid; the message names it.

    Examples
    --------
    A PD law with a filter, u = -(2e4 + 500 s/(1 + s/100)) y, sampled at 10 kHz:

    >>> import control
    >>> s = control.tf("s")
    >>> law = linear_controller(-(2e4 + 500 * s / (1 + s / 100)), ["left.x"], ["left.i_x"], 1e-4)
    >>> round(law.state_space()(1.0).real)  # A/m at rest
    -20000
    """
    if isinstance(K, str | Path):
        given = {
            **{"inputs": inputs, "outputs": outputs, "sample_time": sample_time, "method": method, "prewarp": prewarp},
            **{"sampled_arrays": sampled_arrays, "gains": gains, "offsets": offsets, "limits": limits, "delay": delay},
            **{"slow_time": slow_time, "allow_unstable": allow_unstable},
        }
        return _from_file(Path(K), {name: value for name, value in given.items() if value is not None})
    slow_time = SLOW_TIME if slow_time is None else quantity(slow_time, "s", "slow_time")
    prewarp = None if prewarp is None else quantity(prewarp, "rad/s", "prewarp")
    by_speed = _laws(K, bool(sampled_arrays))
    _check_method(by_speed, {"method": method, "prewarp": prewarp})
    first = next(iter(by_speed.values()))
    time = check_sample_time(_sample_time(first) if sample_time is None else sample_time)
    laws = {}
    for speed, law in by_speed.items():
        with errors_in(f"at {speed:g} rad/s" if len(by_speed) > 1 else ""):
            laws[speed] = sampled(law, time, "tustin" if method is None else method, prewarp)
    _check_alike(laws)
    if not 1e-6 <= slow_time <= 1e6:
        raise ValueError(f"slow_time = {slow_time:g} s is not allowed; it must be >= 1e-06 and <= 1e+06 s")
    if not allow_unstable:
        _check_stable(laws)
    p, m = first.D.shape
    names = (
        _labels(K, "input_labels", inputs, m, "inputs", "measured signals"),
        _labels(K, "output_labels", outputs, p, "outputs", "demands"),
    )
    ports = Ports(*names, len(next(iter(laws.values())).A))
    starts = _starts(
        ports, 1.0 if gains is None else gains, 0.0 if offsets is None else offsets, limits, _samples(delay, time)
    )
    controller = LinearController(laws, ports, time, slow_time, starts, bool(allow_unstable))
    _ = controller.model_and_constants  # raises errors of these arguments
    return controller


def _from_file(path: Path, options: Mapping[str, Any]) -> LinearController:
    """Return the controller in a file; `options` are arguments of `linear_controller` that override the file."""
    from amb_cosim.controllers.array_file import read_arrays
    from amb_cosim.controllers.block_file import read_blocks
    from amb_files.array_files import SUFFIXES

    if not path.is_file():
        raise ValueError(f"no controller file {str(path)!r}")
    if path.suffix not in (*SUFFIXES, ".toml"):
        raise ValueError(f"no controller file {str(path)!r}: its name must end with .toml or {' or '.join(SUFFIXES)}")
    try:
        if "sampled_arrays" in options:
            raise ValueError(
                "sampled_arrays is not allowed; the sample time in the file states whether the arrays are sampled"
            )
        content = read_blocks(path) if path.suffix == ".toml" else read_arrays(path)
        starts, stored = content.pop("starts", {}), content.get("outputs", [])
        controller = linear_controller(**content | dict(options))
        if starts:
            new = dict(zip(stored, controller.ports.demands, strict=False))
            parts = {name: name.rpartition(".") for name in starts}
            starts = {f"{new.get(d, d)}{dot}{last}": starts[name] for name, (d, dot, last) in parts.items()}
            replaced = {parameter for option in options for parameter in PARAMETERS.get(option, ())}
            ours = {name: v for name, v in controller.starts.items() if name.rpartition(".")[2] in replaced}
            controller = replace(controller, starts=starts | ours)
            _ = controller.model_and_constants
    except ValueError as error:
        raise ValueError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from error
    return controller


def _check_method(laws: Mapping[float, Law], given: Mapping[str, object]) -> None:
    """Raise ValueError if a discretisation is given although the laws are already sampled."""
    for name, value in given.items():
        if value is not None and all(law.sample_time is not None for law in laws.values()):
            raise ValueError(f"{name} = {value} is not allowed; the law is already sampled")


def _laws(K: Any, sampled_arrays: bool) -> dict[float, Law]:
    """Return the laws by ascending speed; a single law gets the speed 0."""
    if not isinstance(K, Mapping):
        return {0.0: law_of(K, sampled_arrays)}
    if not K:
        raise ValueError("a controller without speeds is not allowed; it must have a law for at least one speed")
    laws = {}
    for stated, law in K.items():
        speed = quantity(stated, "rad/s", "speed")
        if not abs(speed) <= 1e4:
            raise ValueError(f"a speed of {stated!r} is not allowed; it must be from -1e4 to 1e4 rad/s")
        if speed in laws:
            raise ValueError(f"a speed of {stated!r} occurs twice; each speed must have one law")
        with errors_in(f"at {speed:g} rad/s" if len(K) > 1 else ""):
            laws[speed] = law_of(law, sampled_arrays)
    return dict(sorted(laws.items()))


def _samples(delay: Raw | None, sample_time: float) -> float:
    """Return a delay in samples, which is stated as this number or as a time with a unit."""
    stated = 0.0 if delay is None else plain_value(delay, "delay")
    number = plain_number(stated)
    return quantity(stated, "s", "delay") / sample_time if number is None else number


def _amperes(values: Any, name: str) -> Any:
    """Return currents (A), stated as one value or as nested lists of values, in the same form."""
    if isinstance(values, str) or not isinstance(values, list | tuple | np.ndarray) or np.ndim(values) == 0:
        return quantity(values, "A", name)
    return [_amperes(value, name) for value in values]


def _sample_time(law: Law) -> float:
    if not law.sample_time:
        raise ValueError("sample_time is missing; it is required because K does not state it")
    return law.sample_time


def _check_alike(laws: Mapping[float, Law]) -> None:
    (speed, first), *others = laws.items()
    for other, law in others:
        if law.A.shape != first.A.shape:
            raise ValueError(
                f"{len(first.A)} states at {speed:g} rad/s and {len(law.A)} at {other:g} rad/s are not allowed; "
                "interpolated laws must have the same order"
            )
        if law.D.shape != first.D.shape:
            raise ValueError(
                f"D of shape {first.D.shape} at {speed:g} rad/s and {law.D.shape} at {other:g} rad/s is not allowed; "
                "the laws at all speeds must have the same signals and demands"
            )


def _check_stable(laws: Mapping[float, Law]) -> None:
    if not len(next(iter(laws.values())).A):
        return
    points = [(speed, law.A) for speed, law in laws.items()]
    between = [((1.0 - w) * a + w * b, (1.0 - w) * A + w * B) for (a, A), (b, B) in pairwise(points) for w in WEIGHTS]
    for speed, A in (*points, *between):
        largest = float(np.abs(np.linalg.eigvals(A)).max())
        if largest > STABLE:
            where = f" at {speed:g} rad/s" if len(points) > 1 else ""
            how = " between the given speeds" if speed not in laws else ""
            raise ValueError(
                f"a controller with a pole of magnitude {largest:.9g}{where}{how} is not allowed; the magnitude must "
                "be <= 1 in the z plane, unless allow_unstable is set"
            )


def _labels(
    K: Any, attribute: str, names: Sequence[str] | None, count: int, argument: str, kind: str
) -> tuple[str, ...]:
    law = next(iter(K.values())) if isinstance(K, Mapping) else K
    if isinstance(names, str):
        names = [names]
    if names is None:
        labels = getattr(law, attribute, None)
        if not labels or any("[" in label for label in labels):
            raise ValueError(f"{argument} is missing; it must name the {kind} of this law, {count} in total")
        names = labels
    if not all(isinstance(name, str) for name in names):
        raise ValueError(f"{argument} = {names!r} is not allowed; it must be names")
    if len(names) != count:
        raise ValueError(f"{len(names)} {argument} is not allowed; the law has {count} {kind}")
    return tuple(names)


def _starts(ports: Ports, gains: Any, offsets: Any, limits: Any, delay: float) -> dict[str, float]:
    starts: dict[str, float] = {}
    settings = {"gain": gains, "offset": _amperes(offsets, "offsets")}
    if limits is not None:
        pairs = np.asarray(_amperes(limits, "limits"), dtype=np.float64)
        if pairs.shape not in ((2,), (len(ports.demands), 2)):
            raise ValueError(
                f"limits of shape {pairs.shape} are not allowed; give (lower, upper) in amperes, once for "
                "all demands or once for each demand"
            )
        settings |= {"lower": pairs[..., 0], "upper": pairs[..., 1]}
    for name, values in settings.items():
        each = np.asarray(values, dtype=np.float64)
        if each.shape not in ((), (len(ports.demands),)):
            raise ValueError(
                f"{name} of shape {each.shape} is not allowed; it must be one number, or one for each of "
                f"{len(ports.demands)} demands"
            )
        for demand, value in zip(ports.demands, np.broadcast_to(each, len(ports.demands)), strict=True):
            starts[f"{demand}.{name}"] = float(value)
    for demand in ports.demands:
        low, high = starts.get(f"{demand}.lower"), starts.get(f"{demand}.upper")
        if low is not None and high is not None and not low <= high:
            raise ValueError(
                f"limits of {demand}, {low:g} and {high:g} A, are not allowed; the first must be <= the second"
            )
    return starts | {"delay": float(delay)}
