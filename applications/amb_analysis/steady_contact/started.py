"""A co-simulation that starts in a stable or unstable synchronous state, or in a whirl without unbalance.

The contact forces F of a state turn with the rotor, as unbalance does, so omega = Omega. The forces of a whirl turn
with the whirl. If these forces replace the contact at the sites, the loop with the sampled controller settles to the
state, and `cosim.master.settling` solves for this motion. If the states of the rotor are x = Re[X exp(i omega t)], F
adds the following change to them in a step of length h:

    f = Re[(exp(i omega h) - exp(A h)) X exp(i omega t)],      X = (i omega - A)^-1 B F               (1)

The run continues from this motion with real contact at the sites. Currents held over a sample make N ripple about its
value in the state.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from amb_analysis.linear import components as linear
from amb_analysis.steady_contact.forward_loop import Complex, contact_pair, flat, parts_in_contact
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.trap_map import SolvedState
from amb_analysis.steady_contact.whirl import Whirl
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.master.responses import Response, StateMap
from amb_cosim.cosim.master.settling import SettledLoop, loop_at, solve
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.simulator import Simulator
from amb_cosim.cosim.system.experiment import WARM_UP
from amb_cosim.results.component_names import ACTUATOR, PLANT

PROBE_UNBALANCE = 1e-6  # kg m of unbalance in the warm-up steps, which excites all states without contact


def checkpoint_in(rotor: RubbingRotor, state: SolvedState | Whirl) -> Checkpoint:
    """Return a checkpoint at cycle 0 that starts a run in a state or whirl of the rotor (1).

    Pass the checkpoint to `amb_cosim.run(..., start=checkpoint)`. The rotor's unbalance applies until an event changes
    it.

    Parameters
    ----------
    rotor
        Rotor of a prepared run that begins some cycles before cycle 0.
    state
        State at the speed of the run; for a whirl, the rotor's unbalance is ignored.

    Raises
    ------
    CannotSettle
        If an FMU does not declare its linear states, or the loop without contact is unstable.
    ValueError
        If there are too few steps before cycle 0, or if the run has no input for the rotor's unbalance.
    """
    plan = rotor.machine.prepared
    is_whirl = isinstance(state, Whirl)
    omega = state.frequency if isinstance(state, Whirl) else rotor.Omega
    final_inputs = {**plan.inputs, **_unbalance(replace(rotor, unbalance=0.0 * rotor.unbalance) if is_whirl else rotor)}
    missing = [name for name, value in final_inputs.items() if name not in plan.inputs and value != 0.0]
    if missing:
        raise ValueError(f"the run has no {missing[0]}; add it to the inputs of the scenario, with any value")
    if plan.begin > -(WARM_UP + 2):
        raise ValueError(f"{-plan.begin} steps before cycle 0 are not allowed; at least {WARM_UP + 2} are required")
    with closing(InstancePool()) as instances:
        simulator = Simulator(plan, "plain", instances)
        begin, master = simulator.initialise(), simulator.master
        final = np.array([final_inputs[name] for name in plan.inputs])
        is_amount = np.array([name in final_inputs and name.endswith(".u") for name in plan.inputs], dtype=bool)
        master.exogenous[:] = np.where(is_amount, PROBE_UNBALANCE, final)
        master.run(begin, -2)
        master.exogenous[:] = final
        loop = loop_at(master, plan.assembly, master.run, -2)
        responses = [
            _with_contact(rotor, state, omega, loop, part, response) if part.component.name == PLANT else response
            for part, response in zip(loop.parts, loop.responses(), strict=True)
        ]
        orbit = solve(loop, responses, 0, corrects=False, advance=omega * plan.step_size)
        loop.put(orbit.at(orbit.angle), orbit.angle)
        loop.step()
        for part in loop.parts:
            part.balance_energy()
        return simulator.checkpoint(0)


def _unbalance(rotor: RubbingRotor) -> dict[str, float]:
    """Return the amount (kg m) and the angle (rad) of unbalance at each place, by the names of the inputs."""
    result: dict[str, float] = {}
    for place, u in zip(rotor.places, rotor.unbalance, strict=True):
        result |= {f"{PLANT}.{place}.u": float(abs(u)), f"{PLANT}.{place}.phi": float(np.angle(u))}
    return result


def _with_contact(
    rotor: RubbingRotor, state: SolvedState | Whirl, omega: float, loop: SettledLoop, part: StateMap, response: Response
) -> Response:
    """Return the plant's response with forcing (1) added, for contact forces of a state that turn with omega."""
    linear_rotor, h = _linear_rotor(rotor), loop.master.step_size
    force = [-(N + 1j * state.friction[site]) * np.exp(1j * state.psi[site]) for site, N in state.N.items()]
    F_xy = np.array([F * axis for F in force for axis in (1.0, -1j)])  # x and y of each
    law = linear_rotor.selected(flat([contact_pair(site) for site in state.N]), linear_rotor.outputs).law
    X = np.linalg.solve(1j * omega * np.eye(len(law.A)) - law.A, law.B @ F_xy)
    state_forcing = np.exp(1j * omega * h) * X - expm(law.A * h) @ X
    output_forcing = dict(zip(linear_rotor.outputs, law.C @ state_forcing, strict=True))
    names = [loop.master.wiring.names[at] for at in part.slot[loop.moving[part.slot]]]
    forcing: Complex = np.array(
        [*state_forcing[: len(part.moves)][part.moves], *(output_forcing.get(name, 0.0) for name in names)]
    )
    turns = np.stack([0.0 * forcing.real, forcing.real, -forcing.imag], axis=1)
    return response._replace(forcing=response.forcing + turns)


def _linear_rotor(rotor: RubbingRotor) -> linear.LinearComponent:
    """Return the linear rotor, with the magnets' stiffness if it acts within a step; the rotor's states come first."""
    source = rotor.machine.run_components.at(rotor.Omega)
    within_a_step = any(target.endswith(".k_xx") for target in source.feeds([PLANT, ACTUATOR]))
    parts, feeds = parts_in_contact(source, [PLANT, ACTUATOR] if within_a_step else [PLANT])
    return linear.connected(parts, linear.within(parts, feeds))
