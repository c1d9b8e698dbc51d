"""Names of the models, of the components that run them, and of outputs that several models share."""

from __future__ import annotations

PLANT, ACTUATOR, CONTROLLER = "rotor_contact", "amb_actuator", "rolac_controller"
LIMITED = ("current_limited", "demand_limited")  # outputs of controllers: a demand is at its limit
