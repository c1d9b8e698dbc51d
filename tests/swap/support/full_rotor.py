"""The full finite-element model of the rig's rotor, as a plain PythonFMU slave; no contact, constant speed.

State z = (q, q', c, s) with the spin c = cos theta, s = sin theta, held forces f and the unbalances u on the discs:

    M q'' + (C + Omega G) q' + K q = B f + Omega^2 sum_d u_d B_d (c, s),    c' = -Omega s,    s' = Omega c

A step is exact: (z, f) goes to the exponential of its matrix times (z, f).
"""

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from scipy.linalg import expm

from rotor_analysis.assembly import assemble
from rotor_analysis.rotor_file import load_rotor


class FullRotor(Fmi2Slave):
    """All nodes of the rotor, without reduction."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        rotor = load_rotor()
        self.rotor, self.model = rotor, assemble(rotor)
        self.forces = [f"{bearing.name}.f_{axis}" for bearing in rotor.bearings for axis in "xy"]
        self.unbalances = [f"{disc.name}.u" for disc in rotor.discs]
        self.rows = {
            f"{bearing.name}.{axis}": self.model.translations[bearing.node][k]
            for bearing in rotor.bearings
            for k, axis in enumerate("xy")
        }
        for sensor in rotor.sensors:
            self.rows |= dict(zip((sensor.x, sensor.y), self.model.translations[sensor.node], strict=True))
        self.values = {"Omega": 0.0, "theta": 0.0}
        self.values |= dict.fromkeys([*self.forces, *self.unbalances, *self.rows], 0.0)
        for name in ("Omega", *self.forces, *self.unbalances):
            self._register(name, Fmi2Causality.input)
        for name in ("theta", *self.rows):
            self._register(name, Fmi2Causality.output)
        self.propagator = None

    def _register(self, name, causality):
        variable = Real(
            name,
            causality=causality,
            variability=Fmi2Variability.continuous,
            getter=lambda: self.values[name],
            setter=lambda value: self.values.__setitem__(name, value),
        )
        self.register_variable(variable)

    def exit_initialization_mode(self):
        self.state = np.zeros(2 * self.model.size + 2)
        self.state[-2] = 1.0

    def do_step(self, current_time, step_size):
        arguments = (self.values["Omega"], step_size, *(self.values[name] for name in self.unbalances))
        if self.propagator is None or self.propagator[0] != arguments:
            self.propagator = arguments, self._propagator(step_size)
        forces = [self.values[name] for name in self.forces]
        self.state = self.propagator[1] @ np.concatenate([self.state, forces])
        self.values["theta"] = self.values["Omega"] * (current_time + step_size)
        for name, row in self.rows.items():
            self.values[name] = float(self.state[row])
        return True

    def _propagator(self, h):
        Omega, n = self.values["Omega"], self.model.size
        model = self.model.at(Omega)
        into = np.linalg.inv(model.M)
        A = np.zeros((2 * n + 2 + len(self.forces),) * 2)
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n, :n] = -into @ model.K
        A[n : 2 * n, n : 2 * n] = -into @ (model.C + Omega * model.G)
        for disc in self.rotor.discs:
            rows = list(model.translations[disc.node])
            A[n : 2 * n, 2 * n : 2 * n + 2] += into[:, rows] * Omega**2 * self.values[f"{disc.name}.u"]
        A[2 * n, 2 * n + 1], A[2 * n + 1, 2 * n] = -Omega, Omega
        bearings = [row for b in self.rotor.bearings for row in model.translations[b.node]]
        A[n : 2 * n, 2 * n + 2 :] = into[:, bearings]
        return expm(A * h)[: 2 * n + 2]
