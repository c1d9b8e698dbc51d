"""A mass that a force accelerates, as a plain PythonFMU slave."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Mass(Fmi2Slave):
    """One translational degree of freedom; the force is constant during a step, so that each step is exact."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.m, self.x, self.v, self.force, self.push = 1.0, 0.0, 0.0, 0.0, 0.0
        self.start = 0.0
        parameter = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        self.register_variable(Real("m", **parameter))
        self.register_variable(Real("start", **parameter))
        self.register_variable(Real("force", causality=Fmi2Causality.input))
        self.register_variable(Real("push", causality=Fmi2Causality.input))
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        self.register_variable(Real("v", causality=Fmi2Causality.output))

    def enter_initialization_mode(self):
        self.x = self.start

    def do_step(self, current_time, step_size):
        a = (self.force + self.push) / self.m
        self.x += self.v * step_size + 0.5 * a * step_size**2
        self.v += a * step_size
        return True
