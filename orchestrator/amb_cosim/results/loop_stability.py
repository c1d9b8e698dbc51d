"""The pole that decides whether the loop of a machine is stable, as a record that a run's data set can contain."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Annotated

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.units import frequency_unit

ATTRIBUTE = "loop_stability"  # of a data set: JSON of the loop at the end of the run, if it is known
LARGEST = 1e3  # logarithmic decrement that stands for motion that hardly vibrates


@dataclass(frozen=True)
class LoopStability:
    """The pole that determines stability: the pole of largest modulus, ignoring poles on the unit circle.

    radius
        Its modulus |z|, the spectral radius of the loop.
    growth_rate
        sigma = ln|z|/T; negative if the motion decays.
    frequency
        Frequency |omega| of its vibration; 0 for a drift.
    speed
        Spin speed.
    place
        Bearing at which the rotor moves most; "" if unknown. The axis is included if the motion along it is more than
        twice the motion along the other axis.
    on_circle
        Number of poles that lie on the unit circle except for rounding.
    """

    radius: float
    growth_rate: Annotated[float, "1/s"]
    frequency: Annotated[float, "rad/s"]
    speed: Annotated[float, "rad/s"] = 0.0
    place: str = ""
    on_circle: int = 0

    @property
    def is_stable(self) -> bool:
        """Whether no motion of the loop grows."""
        return self.radius <= 1.0

    @property
    def is_drift(self) -> bool:
        """Whether the motion of the pole is a drift without vibration."""
        return self.frequency == 0.0

    @property
    def decrement(self) -> float:
        """Logarithmic decrement -2 pi sigma/omega, from -`LARGEST` (a growing drift) to `LARGEST`."""
        if self.is_drift:
            return math.copysign(LARGEST, -self.growth_rate)
        return float(np.clip(-2.0 * math.pi * self.growth_rate / self.frequency, -LARGEST, LARGEST))

    @property
    def motion(self) -> str:
        """The kind of motion, the place where it is largest, and its rate of growth or decay, in words."""
        vibration = f"a vibration of {frequency_unit().text(self.frequency, 5)}"
        kind = "a drift without vibration" if self.is_drift else vibration
        place = f", largest at {self.place}," if self.place else ""
        return f"{kind}{place} {'decays' if self.is_stable else 'grows'} by {abs(self.growth_rate):.3g} 1/s"

    @property
    def note(self) -> str:
        """A note on poles on the unit circle; empty if there are none."""
        if not self.on_circle:
            return ""
        count = "1 pole is" if self.on_circle == 1 else f"{self.on_circle} poles are"
        return f"{count} on the unit circle within rounding errors, due to free motion or integrators outside the loop"

    def to_json(self) -> str:
        """Return the record as JSON text, for the attribute of a data set."""
        return json.dumps(asdict(self))


def stability_of_loop(dataset: Signals) -> LoopStability | None:
    """Return the stability of the loop at the end of a run; None if it is not known."""
    text = dataset.attrs.get(ATTRIBUTE)
    return None if text is None else LoopStability(**json.loads(str(text)))
