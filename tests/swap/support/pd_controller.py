"""A controller of four axes, as a plain PythonFMU slave: i = -(k_p x + k_d (x - x_before) / h) / k_i."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

AXES = [f"{bearing}.{{}}{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]


class PdController(Fmi2Slave):
    """Sampled once in a step."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {"k_p": 3e6, "k_d": 5000.0, "k_i": 563.0}
        self.before = None
        for name in self.values:
            self._register(name, Fmi2Causality.parameter, Fmi2Variability.fixed)
        for axis in AXES:
            for name, causality in ((axis.format(""), Fmi2Causality.input), (axis.format("i_"), Fmi2Causality.output)):
                self.values[name] = 0.0
                self._register(name, causality, Fmi2Variability.discrete)

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
        now = [v[axis.format("")] for axis in AXES]
        for axis, x, before in zip(AXES, now, self.before or now, strict=True):
            v[axis.format("i_")] = -(v["k_p"] * x + v["k_d"] * ((x - before) / step_size)) / v["k_i"]
        self.before = now
        return True
