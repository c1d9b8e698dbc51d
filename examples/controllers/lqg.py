"""LQG for the compressor by python-control, on the linear model of rotor and magnetic bearings."""

from __future__ import annotations

import control
import numpy as np

import amb_cosim
from rotor_analysis.reduced_rotor import with_modes
from rotor_analysis.rotor_file import load_rotor

SCENARIO = "compressor_levitated"
AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
SAMPLE_TIME = 1e-4  # s
STIFFNESS = 1e9  # A^2/m^2: what a displacement costs, of which a current of 1 A costs 1
ROTOR = with_modes(load_rotor("compressor"), 6)  # with the two modes of its file, the law drives that of 620 Hz
READING = 1e-12  # m^2/A^2: variance of the readings, over that of disturbing currents


def design_model(scenario=SCENARIO):
    """Return displacements over demanded currents."""
    demands, shown = [f"amb_actuator.{name}" for name in DEMANDS], [f"rotor_contact.{name}" for name in AXES]
    machine = ["rotor_contact", "amb_actuator"]
    return amb_cosim.linearise(scenario, inputs=demands, outputs=shown, components=machine, rotor=ROTOR)


def lqg(scenario=SCENARIO):
    """Return the controller u(n) = -K x(n), x(n+1) = A x(n) + B u(n) + L (y(n) - C x(n))."""
    plant = design_model(scenario)
    A, B, C, _ = control.ssdata(control.sample_system(plant, SAMPLE_TIME, "zoh"))
    K = control.dlqr(A, B, STIFFNESS * C.T @ C, np.eye(len(B.T)))[0]
    L = control.dlqe(A, B, C, np.eye(len(B.T)), READING * np.eye(len(C)))[0]
    law = control.ss(A - B @ K - L @ C, L, -K, np.zeros((len(K), len(C))), SAMPLE_TIME)
    return amb_cosim.linear_controller(law, AXES, DEMANDS, limits=(-6.5, 5.0))


if __name__ == "__main__":
    print(lqg().save("lqg.npz"))
