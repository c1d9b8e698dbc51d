"""A spring between two points, as a plain PythonFMU slave."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Spring(Fmi2Slave):
    """Force on each end from their distance; a spring under compression ends the simulation."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.k, self.left, self.right = 1.0, 0.0, 0.0
        self.on_left, self.on_right = 0.0, 0.0
        self.register_variable(Real("k", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))
        for name in ("left", "right"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
            self.register_variable(Real(f"on_{name}", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.on_left = self.k * (self.right - self.left)
        self.on_right = -self.on_left
        return self.k >= 0.0
