"""The temperature of a retainer, modelled as one heat capacity that friction warms and the surroundings cool.

    C T' = P - h (T - T_ambient)

P is the heat flow from friction, race drag and impacts, assumed constant over a step.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from rotor_contact.contact.site import Site


@kernel
def advance_temperature(site: Site, state: np.record, heat: float, ambient: float, step_size: float) -> None:
    """Update the temperature (K) in the `state` of a site after a step of `step_size` (s) that produced `heat` (J)."""
    if site.heat_capacity == 0.0:
        return
    exponent = site.heat_transfer * step_size / site.heat_capacity
    mean_share = -math.expm1(-exponent) / exponent if exponent > 1e-12 else 1.0
    excess = (state.temperature - ambient) * math.exp(-exponent) + heat / site.heat_capacity * mean_share
    state.temperature = ambient + excess
