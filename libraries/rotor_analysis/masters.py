"""Choice of master planes: the planes of parts, and as many others as the first modes require."""

from __future__ import annotations

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices, on_bearings
from rotor_analysis.reduction import Reduction, msdc
from rotor_analysis.rotor import Rotor
from rotor_analysis.undamped import undamped_modes

SLOW = 0.1  # rad/s; slower modes are those of a rotor that hardly bends, on bearings that hardly support it


def needed_masters(rotor: Rotor) -> tuple[int, ...]:
    """Return the nodes of discs, bearings, seals, sites and sensors, ascending.

    If there are fewer than two nodes, the end nodes are added.
    """
    nodes = {*rotor.disc_nodes, *rotor.bearing_nodes, *rotor.seal_nodes, *rotor.site_nodes, *rotor.sensor_nodes}
    ends = {1, len(rotor.shaft.nodes)} if len(nodes) < 2 else set()
    return tuple(sorted(nodes | ends))


def condense_to_accuracy(full: Matrices, rotor: Rotor, modes: int, accuracy: float) -> Reduction:
    """Condense a model to the planes of parts and as many other planes as the first modes require.

    Each new plane is placed at the largest error of the least accurate mode.

    Parameters
    ----------
    full
        The finite-element model of the free rotor.
    rotor
        Description of the rotor.
    modes
        Number of modes that must be accurate.
    accuracy
        Allowed relative error of their frequencies.

    Raises
    ------
    ValueError
        If even all planes together do not reach the accuracy.
    """
    frequencies, shapes = undamped_modes(on_bearings(full, rotor), rotor, modes)
    masters = needed_masters(rotor)
    while True:
        reduction = msdc(full, masters)
        error = frequency_error(frequencies, undamped_modes(on_bearings(reduction.model, rotor), rotor, modes)[0])
        others = [node for node in full.translations if node not in masters]
        if np.max(error) <= accuracy:
            return reduction
        if not others:
            what = f"with all planes retained, the error is {np.max(error):.1e}; allow this error, or use free_modes"
            raise ValueError(f"reduction.accuracy = {accuracy:g} is not reached: {what}")
        shape = shapes[:, np.argmax(error)]
        x = reduction.right[::2, ::2]
        residual = np.abs(shape - x @ shape[[row // 2 for row in full.rows(masters)[::2]]])
        added = max(others, key=lambda node: residual[full.translations[node][0] // 2])
        masters = tuple(sorted((*masters, added)))


def frequency_error(exact: Array, frequencies: Array) -> Array:
    """Return |frequencies / exact - 1| of each frequency, infinite for missing ones, shape (len(exact),).

    Rounding of the stiffness adds an error to the squares of the frequencies. The errors of frequencies below `SLOW`
    are therefore taken relative to `SLOW`.
    """
    error, frequencies = np.full(len(exact), np.inf), frequencies[: len(exact)]
    compared = exact[: len(frequencies)]
    is_slow = np.abs(compared) < SLOW
    slow = np.abs(frequencies * np.abs(frequencies) - compared * np.abs(compared)) / (2.0 * SLOW**2)
    error[: len(frequencies)] = np.where(is_slow, slow, np.abs(frequencies / np.where(is_slow, 1.0, compared) - 1.0))
    return error
