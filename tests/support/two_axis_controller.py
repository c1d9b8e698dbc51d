"""A phase lead on the two axes of a bearing: the example of the reference page of linear controllers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amb_cosim.controllers.laws import law_of, side_by_side
from amb_cosim.controllers.linear_controller import linear_controller
from array_types import Array

if TYPE_CHECKING:
    from fmi_export.model import Model


def two_axes() -> tuple[Model, Array]:
    """Return its model and constants."""
    lead = law_of(([-40.0, -2e4], [2e-4, 1.0]))
    return linear_controller(
        side_by_side([lead, lead]), ["left.x", "left.y"], ["left.i_x", "left.i_y"], 100e-6
    ).model_and_constants
