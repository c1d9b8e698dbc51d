"""A machine that is not the rig: twelve impellers, three bearings, six contact sites, three sensor planes."""

import numpy as np
from rotor_cases import STEEL

from rotor_analysis.parts import Bearing, Disc, Sensor, Site
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft

NODES = tuple(np.linspace(0.0, 2.4, 25).round(3).tolist())
IMPELLERS = (3, 5, 7, 8, 10, 11, 13, 14, 16, 18, 20, 23)
HELD, TOUCHING = (2, 12, 24), (2, 6, 9, 12, 19, 24)
SITES = ("rb1", "seal1", "seal2", "rb2", "seal3", "rb3")


def machine(**changes):
    """Twelve impellers, three bearings with their retainers, three seals that can rub."""
    shaft = Shaft(diameter=(0.09,), nodes=NODES, **STEEL)
    bodies = tuple(Disc(f"impeller{k}", node, 8.0, 0.15, 0.04, unbalance=True) for k, node in enumerate(IMPELLERS, 1))
    owners = ("mb1", None, None, "mb2", None, "mb3")
    values = {
        "bodies": bodies,
        "bearings": tuple(Bearing(f"mb{k}", node) for k, node in enumerate(HELD, 1)),
        "sites": tuple(Site(n, node, 0.2e-3, bearing=b) for n, node, b in zip(SITES, TOUCHING, owners, strict=True)),
        "sensors": tuple(Sensor(f"probe{k}", node) for k, node in enumerate((1, 12, 25), 1)),
        "reduction": ReductionOptions(),
    }
    return Rotor("machine", shaft, **(values | changes))


def held(count, k_b=2e6, c_b=2e3):
    """Parameters of springs and dampers in the first `count` bearings."""
    return {f"mb{k}.{name}": v for k in range(1, count + 1) for name, v in (("k_b", k_b), ("c_b", c_b))}
