"""Rotor, magnetic bearings and controller in one model, coupled at the controller's samples."""

KERNELS_FROM = ("rolac_controller", "amb_actuator", "rotor_contact")  # packages whose kernels the kernels here call
