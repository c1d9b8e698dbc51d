"""A casing that moves as a whole: a mass on a spring, which the bearing forces push and whose motion moves the base."""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

FORCES = [f"f{number}_{axis}" for number in (1, 2) for axis in "xy"]  # of the bearings, N
PARAMETERS = {"mass": 2000.0, "frequency": 80.0, "damping_ratio": 0.02}  # kg, Hz, 1
SUBSTEPS = 20


class Casing(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {**PARAMETERS, **dict.fromkeys([*FORCES, "base.a_x", "base.a_y", "casing.x", "casing.y"], 0.0)}
        self.velocity = {"x": 0.0, "y": 0.0}
        for name in self.values:
            self.register_variable(self.port(name))

    def port(self, name):
        is_input, is_parameter = name in FORCES, name in PARAMETERS
        return Real(
            name,
            causality=getattr(Fmi2Causality, "parameter" if is_parameter else "input" if is_input else "output"),
            variability=Fmi2Variability.tunable if is_parameter else Fmi2Variability.continuous,
            getter=lambda: self.values[name],
            setter=lambda value: self.values.__setitem__(name, value),
        )

    def do_step(self, current_time, step_size):
        omega, h = 2.0 * math.pi * self.values["frequency"], step_size / SUBSTEPS
        for axis, v in self.velocity.items():
            force = -sum(self.values[name] for name in FORCES if name.endswith(axis))  # the reaction of the magnets
            x = self.values[f"casing.{axis}"]
            for _ in range(SUBSTEPS):
                acceleration = (
                    force / self.values["mass"] - 2.0 * self.values["damping_ratio"] * omega * v - omega**2 * x
                )
                v += h * acceleration
                x += h * v
            self.velocity[axis], self.values[f"casing.{axis}"], self.values[f"base.a_{axis}"] = v, x, acceleration
        return True
