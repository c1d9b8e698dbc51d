"""Description of a controller file: its connections, their phases at the modes of a rotor, and its poles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from amb_analysis.linear.components import harmonic_response
from amb_analysis.studies.result import DrawnResult
from amb_cosim.controllers.block_file import read_blocks
from amb_cosim.controllers.laws import Law
from amb_cosim.controllers.linear_controller import LinearController, linear_controller
from amb_cosim.cosim.system.values import quantity
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from array_types import Array, Complex

LOWEST, POINTS = 1e-4, 600  # lowest frequency over half the sampling frequency, and number of frequencies
AT_REST = 1e-8  # frequency over half the sampling frequency, at which a law is as at rest
CHANGED = 3.0  # factor by which a gain changes with a tenth of the frequency if it is infinite, or zero, at rest
ROUNDING = 1e-6  # of the largest gain at rest; smaller ones are zero


@dataclass(frozen=True)
class LawPath:
    """A connection from a signal to a demand: sampled and, if available, continuous frequency responses.

    `at_modes` contains the sampled responses at the modes of the rotor. `at_rest` is the static gain, which is infinite
    if the connection integrates.
    """

    signal: str
    demand: str
    sampled: Complex
    continuous: Complex | None
    at_modes: Complex
    at_rest: float


@dataclass(frozen=True, eq=False, repr=False)
class ControllerDescription(DrawnResult):
    """A controller at one speed of its table (rad/s), its responses at `omega` (rad/s), and the modes of a rotor."""

    name: ClassVar[str] = "controller"

    controller: LinearController
    speed: float
    omega: Array
    connections: list[LawPath]
    modes: tuple[float, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the description as JSON data; a static gain is None if the law integrates the signal."""
        law = self.controller.laws[self.speed]
        return {
            "sample_time_s": self.controller.sample_time,
            "speeds_rad_s": list(self.controller.laws),
            "speed_rad_s": self.speed,
            "states": len(law.A),
            "largest_pole": float(np.abs(np.linalg.eigvals(law.A)).max()) if len(law.A) else 0.0,
            "connections": [
                {
                    "signal": path.signal,
                    "demand": path.demand,
                    "gain_at_rest": path.at_rest if np.isfinite(path.at_rest) else None,
                    "largest_gain": float(np.abs(path.sampled).max()),
                    "phase_at_modes_deg": np.degrees(np.angle(path.at_modes)).tolist(),
                }
                for path in self.connections
            ],
            "modes_hz": [mode / (2.0 * np.pi) for mode in self.modes],
        }

    def text(self) -> list[TextBlock]:
        """Return a line about the states and the sampling, and the table of the connections."""
        data = self.as_dict()
        headings = (
            "signal",
            "demand",
            "static gain (A/m)",
            "largest (A/m)",
            *(f"{hz:.4g} Hz" for hz in data["modes_hz"]),
        )
        title = "Connections" + ("; phase at the modes (deg)" if self.modes else "")
        table = text_table(title, headings, left=("signal", "demand"))
        for path in data["connections"]:
            at_rest = path["gain_at_rest"]
            gains = ("infinite" if at_rest is None else number(at_rest), number(path["largest_gain"]))
            phases = (f"{phase:z.1f}" for phase in path["phase_at_modes_deg"])
            table.add_row(path["signal"], path["demand"], *gains, *phases)
        sampled = f"{data['states']} states, sampled every {data['sample_time_s']:g} s"
        return [f"{sampled}; largest pole {data['largest_pole']:.6g} in the z plane", table]


def describe_controller(file: Path, speed: str, modes: Sequence[float]) -> ControllerDescription:
    """Describe a controller at the table speed nearest to `speed`, with the modes (rad/s) below its Nyquist frequency.

    Raises
    ------
    ValueError
        If the file or the speed is not allowed.
    """
    controller = linear_controller(file)
    requested = quantity(speed, "rad/s", "speed")
    nearest = min(controller.laws, key=lambda point: abs(point - requested))
    omega = frequencies(controller)
    below = tuple(mode for mode in modes if mode < omega[-1])
    law = read_blocks(file, continuous=True)["K"] if file.suffix == ".toml" else None  # arrays are sampled
    paths = connections(controller, omega, nearest, law[nearest] if isinstance(law, dict) else law, below)
    return ControllerDescription(controller, nearest, omega, paths, below)


def response(law: Law, omega: Array, sample_time: float | None) -> Complex:
    """Return the `harmonic_response` of a law at angular frequencies (rad/s), shape (n, n_demands, n_signals)."""
    return np.asarray([harmonic_response(law, point, sample_time) for point in omega])  # memory as of one


def frequencies(controller: LinearController) -> Array:
    """Return angular frequencies up to half the sampling frequency (rad/s)."""
    nyquist = np.pi / controller.sample_time
    return np.asarray(np.geomspace(LOWEST * nyquist, 0.999 * nyquist, POINTS))


def connections(
    controller: LinearController, omega: Array, speed: float, continuous: Law | None, modes: Sequence[float] = ()
) -> list[LawPath]:
    """Return the connections of a controller at one speed of its table, with their responses.

    The responses of the continuous law are included if there is one. All responses include the controller's `delay`,
    which multiplies them by exp(-j omega delay T).
    """

    def delayed(values: Complex, at: Array) -> Complex:
        late = controller.sample_time * controller.starts.get("delay", 0.0)
        return np.asarray(np.exp(-1j * at * late)[:, None, None] * values)

    law, points = controller.law_at(speed), np.array([*modes])
    result = delayed(response(law, omega, controller.sample_time), omega)
    continuous_response = None if continuous is None else delayed(response(continuous, omega, None), omega)
    shape = (0, *result.shape[1:])
    at_modes = (
        delayed(response(law, points, controller.sample_time), points) if len(points) else np.zeros(shape, complex)
    )
    at_rest = gains_at_rest(law, controller.sample_time)
    return [
        LawPath(
            signal,
            demand,
            result[:, i, j],
            None if continuous_response is None else continuous_response[:, i, j],
            at_modes[:, i, j],
            float(at_rest[i, j]),
        )
        for i, demand in enumerate(controller.ports.demands)
        for j, signal in enumerate(controller.ports.signals)
        if np.any(np.abs(result[:, i, j]) > 1e-12 * np.abs(result).max())
    ]


def gains_at_rest(law: Law, sample_time: float) -> Array:
    """Return the static gains of a sampled law, shape (n_demands, n_signals); infinite where the law integrates.

    The static gain is the limit as the frequency approaches zero, so it is infinite for a gain proportional to 1/omega,
    and zero for a gain proportional to omega.
    """
    slow = AT_REST * np.pi / sample_time
    gain, slower = np.abs(response(law, np.array([slow, 0.1 * slow]), sample_time))
    result = np.where(slower > CHANGED * gain, np.inf, np.where(CHANGED * slower < gain, 0.0, slower))
    finite = result[np.isfinite(result)]
    return np.where(result < ROUNDING * finite.max(initial=0.0), 0.0, result)


def degrees(values: Complex) -> Array:
    """Return the phase of a response in degrees, without jumps."""
    return np.asarray(np.degrees(np.unwrap(np.angle(values))))
