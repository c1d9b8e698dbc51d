"""The friction that drives a fall in rigid retainers over their top, in closed form."""

import math

from scipy.optimize import brentq


def friction_over_top(height: float = 1.0, least: float = 0.0, most: float = 0.6) -> float:
    """Return the friction with which a rigid rotor whirls that falls by a multiple of the clearance.

    With N + W cos theta = 0 at the top, from the linear equation of u = (theta')^2 with u(0) = 2 g h/c:

        2 (h (1 + 4 mu^2) - 1 + 2 mu^2) exp(2 pi mu) = 3
    """

    def at_top(mu: float) -> float:
        return 2.0 * (height * (1.0 + 4.0 * mu**2) - 1.0 + 2.0 * mu**2) * math.exp(2.0 * math.pi * mu) - 3.0

    return brentq(at_top, least, most)


RIGID = friction_over_top()  # from the centre: 12 mu^2 exp(2 pi mu) = 3
