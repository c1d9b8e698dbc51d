"""Sensors: convert the displacements of the rotor to the readings of the controller.

displacement -> axial offset -> scale -> signal chain (`signal_chain.readings`)
"""

from __future__ import annotations

from fmi_export.jit import inlined_kernel
from fmi_export.model import Array
from rolac_controller.records import Inputs, Parameters
from signal_chain.readings import SensorMemory, read


@inlined_kernel
def plane_weight(parameters: Parameters, plane: int, other: int) -> float:
    """Return the weight of the displacement at plane `other` in the displacement at the sensors of `plane`.

    Sensors may be offset axially from their plane. The assumed shape of the bent shaft is Lagrange's polynomial through
    the displacements at all planes.
    """
    z = parameters.plane_positions[plane] + parameters.plane_offsets[plane]
    z_other = parameters.plane_positions[other]
    weight = 1.0
    for k in range(parameters.plane_positions.shape[0]):
        if k != other:
            z_k = parameters.plane_positions[k]
            weight *= (z - z_k) / (z_other - z_k)
    return weight


@inlined_kernel
def displacement_at(parameters: Parameters, inputs: Inputs, plane: int, axis: int) -> float:
    """Return the displacement (m) of the rotor at a plane's sensor for axis x (0) or y (1)."""
    if parameters.plane_offsets[plane] == 0.0:
        at_plane: float = inputs.displacements[2 * plane + axis]
        return at_plane
    total = 0.0
    for other in range(parameters.plane_positions.shape[0]):
        total += plane_weight(parameters, plane, other) * inputs.displacements[2 * other + axis]
    return total


@inlined_kernel
def measure(
    parameters: Parameters, inputs: Inputs, memory: SensorMemory, started: bool, sampling: bool, measured: Array
) -> bool:
    """Compute the readings of the sensors at this sample; return whether one is beyond the ADC range.

    Parameters
    ----------
    memory
        Memory of the sensors; changed.
    started, sampling
        As in `signal_chain.readings.read`.
    measured
        Receives the readings as displacements, shape (n_sensors,) (m).
    """
    for s in range(measured.shape[0]):
        measured[s] = parameters.sensor_scales[s] * displacement_at(parameters, inputs, s // 2, s % 2)
    return read(parameters.common[0], inputs.faults, memory, started, sampling, measured)
