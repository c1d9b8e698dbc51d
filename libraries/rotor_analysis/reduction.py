"""Multiple static-dynamic condensation (MSDC) of the rotor to a few planes (thesis 3.8 to 3.13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fmi_export.model import Array
from rotor_analysis.assembly import Matrices


@dataclass(frozen=True)
class Reduction:
    """A reduced model and its relation to the full model.

    model
        Matrices on the masters: x and y of each master plane in order.
    right, left
        Full displacement = `right` @ masters, reduced force = `left` @ full force. For symmetric K `left` is the
        transpose of `right`; cross-coupled bearings make them differ.
    """

    model: Matrices
    right: Array
    left: Array


def msdc(full: Matrices, planes: tuple[int, ...]) -> Reduction:
    """Condense a model to the translations at `planes`.

    R_D = K_ss^-1 K_sm,  q_s = -R_D q_m;  R_E = K_ms K_ss^-1
    X_R = X_mm - R_E X_sm - X_ms R_D + R_E X_ss R_D  for X = M, C, G     (3.12)
    K_R = K_mm - R_E K_sm,  f_R = f_m - R_E f_s                          (3.11, 3.13)

    Parameters
    ----------
    full
        The model to reduce.
    planes
        Node numbers whose translations are kept.

    Raises
    ------
    ValueError
        If a plane has no translations in `full`, or the slaves can move freely with the masters held (K_ss singular).
    """
    unknown = [node for node in planes if node not in full.translations]
    if unknown:
        raise ValueError(f"planes {unknown} are not in the model; there are {sorted(full.translations)}")
    masters = full.rows(planes)
    slaves = [row for row in range(full.size) if row not in set(masters)]
    K_ss = full.K[np.ix_(slaves, slaves)]
    if slaves and np.linalg.cond(K_ss) > 1e14:
        raise ValueError(f"planes {list(planes)} do not hold the rotor: keep at least two planes of the shaft")
    right = np.zeros((full.size, len(masters)))
    left = np.zeros((len(masters), full.size))
    right[masters] = np.eye(len(masters))
    left[:, masters] = np.eye(len(masters))
    right[slaves] = -np.linalg.solve(K_ss, full.K[np.ix_(slaves, masters)])
    left[:, slaves] = -np.linalg.solve(K_ss.T, full.K[np.ix_(masters, slaves)].T).T
    reduced = Matrices(
        M=left @ full.M @ right,
        C=left @ full.C @ right,
        G=left @ full.G @ right,
        K=left @ full.K @ right,
        translations={node: (2 * i, 2 * i + 1) for i, node in enumerate(planes)},
    )
    return Reduction(reduced, right, left)
