"""Names of the models, and of the components of systems that run them."""

from __future__ import annotations

PLANT, ACTUATOR, CONTROLLER = "rotor_contact", "amb_actuator", "rolac_controller"
