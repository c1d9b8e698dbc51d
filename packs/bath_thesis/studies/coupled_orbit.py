"""Co-simulation of the three FMUs; its orbit is compared with the orbit of the monolithic system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_actuator.interface import DYNAMIC, IDEAL, MEASURED, NONLINEAR
from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.scenario.coupling import delay
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, make_scenario
from amb_cosim.scenario.simulation import execute
from array_types import Complex
from bath_thesis.studies.monolithic import Levitation

SUBSTEP = 15.625e-6  # s, of the plant's integration; the shortest communication step


@dataclass(frozen=True)
class Scheme:
    """Coupling of FMUs.

    A scheme defines the order in which the master steps the FMUs, and whether the force has a gradient within a step or
    is held. It also defines whether the force depends on the mean or the final current of a step. Because the order
    causes a delay, a scheme defines as well whether the controller predicts the displacements over this delay.
    """

    coupling: Coupling = "gauss_seidel"
    gradient: bool = True
    mean_current: bool = False
    predicts: bool = False


def cosimulated(
    levitation: Levitation,
    scheme: Scheme,
    step: float,
    samples: int,
    options: RunOptions = DEFAULTS,
) -> Complex:
    """Return the complex displacement (m) at both bearings and each sample, from a co-simulation of the three FMUs.

    Parameters
    ----------
    levitation
        Rotor, bearings and controller.
    scheme, step
        The coupling, and the communication step (s), which divides the sample time.
    samples
        Number of samples of the controller.
    options
        Options of the run, which include the flavour of the FMUs.

    Raises
    ------
    ValueError
        If the co-simulation does not reach its end.
    """
    result = execute(prepare_run(scenario(levitation, scheme, step, samples), options=options), options)
    if result.outcome.failure is not None:
        raise ValueError(result.outcome.failure)
    bearings = [
        result.signals[f"rotor_contact.{at}.x"].values + 1j * result.signals[f"rotor_contact.{at}.y"].values
        for at in ("mb1", "mb2")
    ]
    return np.array(bearings).T


def scenario(levitation: Levitation, scheme: Scheme, step: float, samples: int) -> Scenario:
    """Return the scenario of a co-simulation, in which an unbalanced rotor starts from rest."""
    actuator: dict[str, float] = {
        "force_law": NONLINEAR if levitation.nonlinear else MEASURED,
        "amplifier": IDEAL if levitation.bandwidth is None else DYNAMIC,
        "mean_current": scheme.mean_current,
        "*.k_s_measured_?": levitation.k_s,
        "*.k_i_measured_?": levitation.k_i,
    }
    if levitation.bandwidth is not None:
        actuator["*.bandwidth_?"] = levitation.bandwidth
    return make_scenario(
        {
            "description": "An unbalanced rotor from rest",
            "Omega": levitation.Omega,
            "settle_cycles": 0,
            "end_time": samples * levitation.sample_time,
            "gradient": scheme.gradient,
            "coupling": scheme.coupling,
            "communication_step": step,
            "inputs": {"rotor_contact": {f"{levitation.disc}.u": levitation.unbalance}},
            "parameters": {
                "rotor_contact": {"solver.max_substep": SUBSTEP},
                "amb_actuator": actuator,
                "rolac_controller": {
                    "sample_time": levitation.sample_time,
                    "prediction_time": delay(scheme.coupling, step) if scheme.predicts else 0.0,
                    "*.k_s_?": levitation.k_s,
                    "*.k_i_?": levitation.k_i,
                    "*.k_b_?": levitation.k_b,
                    "*.c_b_?": levitation.c_b,
                },
            },
            "record": {"variables": ["rotor_contact.mb?.?"], "every": round(in_steps(levitation.sample_time, step))},
        },
        "coupling",
    )
