"""Linear magnetic bearings, as a plain PythonFMU slave: f = k_i i + k_s x, held over a step; no gradient is passed."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

AXES = [(bearing, axis) for bearing in ("mb1", "mb2") for axis in "xy"]


class LinearActuator(Fmi2Slave):
    """Four axes."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {"k_s": 2e6, "k_i": 563.0}
        for name in self.values:
            self._register(name, Fmi2Causality.parameter, Fmi2Variability.fixed)
        for bearing, axis in AXES:
            for name in (f"{bearing}.i_{axis}", f"{bearing}.{axis}", f"{bearing}.f_{axis}"):
                self.values[name] = 0.0
                causality = Fmi2Causality.output if ".f_" in name else Fmi2Causality.input
                self._register(name, causality, Fmi2Variability.continuous)

    def _register(self, name, causality, variability):
        variable = Real(
            name,
            causality=causality,
            variability=variability,
            getter=lambda: self.values[name],
            setter=lambda value: self.values.__setitem__(name, value),
        )
        self.register_variable(variable)

    def do_step(self, current_time, step_size):
        v = self.values
        for bearing, axis in AXES:
            force = v["k_i"] * v[f"{bearing}.i_{axis}"] + v["k_s"] * v[f"{bearing}.{axis}"]
            v[f"{bearing}.f_{axis}"] = force
        return True
