"""The controller of a first design: sample time, PID, and the behaviour and shortfalls of the sampled loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from amb_analysis.machine.machine import Machine
from amb_assessment.first_design.levitation import (
    Designer,
    Levitation,
    Pid,
    growth_in_runs,
    levitation_of,
    operating_points,
    pid_of,
)
from amb_assessment.first_design.shortfalls import (
    advice,
    high_voltage,
    hindering_positions,
    loop_shortfalls,
    shortfalls,
    soft_bearings,
)
from amb_assessment.first_design.sizing import MachineSizes
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import RPM
from amb_cosim.scenario.scenario import Scenario

START = (1.0, 1.0, 0.2)  # ratios (`pid_of`) of the gains in the scenario that is linearised


@dataclass(frozen=True)
class Design:
    """A controller.

    sample_time
        Sample time of the controller (s).
    pid
        Gains.
    levitation
        Behaviour of the sampled loop; None before it is computed.
    shortfalls
        Sentences about missed targets and their causes.
    rejected
        The designs with other sample times that were tried; their shortfalls are those of the loop alone.
    refusal
        Why the design levitates nothing, and what to change; empty if it levitates the rotor.
    """

    sample_time: float
    pid: Pid
    levitation: Levitation | None = None
    shortfalls: tuple[str, ...] = ()
    rejected: tuple[Design, ...] = ()
    refusal: str = ""

    @property
    def loop(self) -> Levitation:
        """Behaviour of the sampled loop."""
        assert self.levitation is not None, "the loop of this design has not been computed"
        return self.levitation


Progress = Callable[[float, int], None]  # sample time (s), number of gains tried at it


def first_design(
    sizes: MachineSizes,
    scenario: Callable[[Design], Scenario],
    options: RunOptions,
    progress: Progress = lambda sample_time, tried: None,
    *,
    sample_times: Sequence[float],
) -> Design:
    """Return the design with the first sample time that reaches zone A, or else the design closest to its targets.

    If no design levitates the rotor, the closest one has a `refusal`, which names the growing motion and a change.

    Parameters
    ----------
    sizes
        Sizes of the magnets.
    scenario
        Function that returns the scenario of the machine with a designed controller.
    options
        Options of the linearisation; only the flavour of the FMUs is used.
    progress
        Function that is called with a sample time and the number of sets of gains tried with it.
    sample_times
        Sample times (s) in the order in which they are tried.
    """
    k_s = {bearing: point.k_s for bearing, point in operating_points(sizes).items()}
    candidates = []
    for sample_time in sample_times:
        start = pid_of(k_s, [*START[:2] * len(k_s), START[2]], sample_time)
        designer = Designer(scenario(Design(sample_time, start)), sizes, options, partial(progress, sample_time))
        pid = designer.best()
        machine = designer.machine(pid)
        levitation = replace(
            levitation_of(machine.loop, sizes.speed, pid, designer.wanted),
            motion_in_runs=growth_in_runs(machine.run_loop, sizes.speed),
        )
        candidates.append((Design(sample_time, pid, levitation), machine))
        if levitation.zone == "A" and levitation.holds:
            break
    best, machine = min(candidates, key=lambda item: item[0].loop.lack)
    others = tuple(item for item, _ in candidates if item is not best)
    rejected = tuple(replace(item, shortfalls=tuple(loop_shortfalls(item.loop))) for item in others)
    if not best.loop.is_stable:
        refusal = _refusal(sizes, best, machine)
        return replace(best, shortfalls=tuple(high_voltage(sizes)), rejected=rejected, refusal=refusal)
    missed = (*shortfalls(machine, best.loop, sizes.speed), *soft_bearings(best.pid, k_s), *high_voltage(sizes))
    return replace(best, shortfalls=missed, rejected=rejected)


def _refusal(sizes: MachineSizes, best: Design, machine: Machine) -> str:
    """Return the message that no PID levitates the rotor, with the growing motion and a suggested change."""
    loop = best.loop
    gains = ", ".join(f"{k:.3g} N/m" for k in best.pid.k_b.values())
    return "; ".join(
        (
            f"none of the PIDs tried levitates rotor {sizes.rotor.name!r} up to {sizes.speed * RPM:.0f} rpm: with the "
            f"best PID (stiffness {gains}), {loop.least_damped}",
            *(tuple(hindering_positions(machine, loop, sizes.speed)) or (advice(sizes.rotor, loop, sizes.speed),)),
        )
    )
