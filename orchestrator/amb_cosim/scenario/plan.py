"""A scenario as an experiment in seconds: cycles become times, unbalances are scaled, and speed points are joined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from amb_cosim.cosim.grid.time_grid import in_steps, is_on_grid, nearest_point, nearest_steps
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.experiment import Experiment, InputChange, Plan, Profile
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.values import Raw, convert, plain_number, quantity
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.places import RotorPlaces, places_of
from amb_cosim.results.signal_arrays import CONTROL_ACTS
from amb_cosim.results.stability import needed as judged_by_stability
from amb_cosim.scenario.control_loop import check_control_loop, excitations
from amb_cosim.scenario.coupling import delay, predictable
from amb_cosim.scenario.far_values import StatedValues
from amb_cosim.scenario.gravity import set_gravity
from amb_cosim.scenario.operating_point import (
    MissingParameters,
    set_operating_points,
    set_test_force,
    stated_constants,
)
from amb_cosim.scenario.plan_warnings import (
    idle_switches,
    implausible_sizes,
    implausible_unbalances,
    unsteady_effects,
    viscous_losses,
)
from amb_cosim.scenario.scenario import SPEED, UNBALANCE, Scenario, checked_speed, cycle_period
from amb_cosim.scenario.scenario_tables import Event, InputProfile
from amb_cosim.scenario.stators import set_stators
from amb_files.checks import errors_in
from fmi_export.variables import OverStep

ACCELERATION = "Omega_dot"  # the shared signal that holds the slope of the speed over the coming step
FREE, IDEAL = "spin.free", "drive.ideal"  # of the plant: a spin that the drive must hold, and a drive that does
ANGLE = "initial.angle"  # parameter of a rotor, its angle at the start


@dataclass(frozen=True, kw_only=True)
class ScenarioPlan(Plan):
    """The plan of a scenario, together with the scenario."""

    scenario: Scenario

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self.scenario.name

    @property
    def speed(self) -> float:
        """Initial speed in rad/s."""
        return self.inputs[SPEED]

    @property
    def profile(self) -> tuple[tuple[int, float], ...]:
        """Points (communication point, rad/s) between which the speed is linear; empty if the speed is constant."""
        return next((ramp.points for ramp in self.ramps if ramp.variable == SPEED), ())


def scenario_plan(
    scenario: Scenario,
    assembly: Assembly,
    settings: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    recorded: Sequence[str] | None = None,
    first: ScenarioStart | None = None,
) -> ScenarioPlan:
    """Plan a scenario on the time grid of the master; settling precedes cycle 0, which begins at time 0.

    Parameters
    ----------
    scenario, assembly
        The scenario and its FMUs. Signals of the rotor's places are always recorded, because figures need them.
    settings
        Values by `component.variable`, or by a signal's name, that replace the scenario's initial values.
    until
        End of the run, measured from the beginning of cycle 0, in s or with a unit; it replaces the scenario's end. It
        is rounded to whole steps, and a notice reports the rounding.
    recorded
        Patterns of all recorded variables, instead of those that scenario, summary and figures require.
    first
        The result of `start_of` for the same scenario and settings, if it is known; the events may differ.

    Raises
    ------
    ValueError
        If a name does not exist, a value is not allowed, a time does not fit the steps, a sensor is not connected, or a
        table of receptances belongs to another loop.
    """
    first = first or start_of(scenario, assembly, settings)
    values = first.values.copy()
    experiment = _experiment(scenario, assembly, first, values, until, recorded)
    plan = experiment_plan(experiment, assembly, values=values)
    parameters = _with_first_angle(plan, scenario.settle_cycles)
    warnings = (*plan.warnings, *implausible_unbalances(plan))
    result = ScenarioPlan(**{**vars(plan), "parameters": parameters, "warnings": warnings}, scenario=scenario)
    check_control_loop(result)
    return result


def _experiment(
    scenario: Scenario,
    assembly: Assembly,
    first: ScenarioStart,
    values: Assignments,
    until: Raw | None,
    recorded: Sequence[str] | None,
) -> Experiment:
    """Return a scenario as an experiment in seconds; `values` receives the state of the drive before its release."""
    coupling = scenario.coupling or assembly.system.coupling
    period, h = cycle_period(values.inputs[SPEED]), scenario.step_size(coupling)
    end, notices = _end(scenario, until, period, h)
    asked = _asked_end(scenario, until, period)
    notices += tuple(
        f"{change.described} at {time:.6g} s (cycle {time / period:.4g}) has no effect: the run ends at {asked:.6g} s "
        f"(cycle {asked / period:.4g})"
        for change, time in late_changes(scenario, until, period)
    )
    with errors_in(f"scenario {scenario.name}"):
        changes: list[InputChange] = []
        for number, event in enumerate(scenario.event, 1):
            time, label = event.moment(period), f"event {event.name or number}"
            changes += [InputChange(time, name, value, label) for name, value in _scaled(event.set, scenario, values)]
        marks = {change.name: change.moment(period) for change in scenario.named_changes}
        changes += _release(scenario, values, changes, marks)
        profiles = _speed_profile(scenario, values, period)
        profiles += _with_acceleration([item for table in scenario.profile for item in table.profiles(0.0)], values)
    return Experiment(
        step_size=h,
        stop_time=end,
        start_time=-scenario.settle_cycles * period,
        events=tuple(changes),
        profiles=profiles,
        stops=tuple(stop.condition(period) for stop in scenario.stop),
        recorded=scenario.record.variables if recorded is None else (),
        essential=_essential(places_of(assembly)) if recorded is None else tuple(recorded),
        record_every=scenario.record.every,
        each=_judged(assembly, profiles) if scenario.record.every > 1 else {},
        record_settling=bool(scenario.record.settling),
        settling=scenario.settling,
        period=period,
        marks=marks,
        unsolvable=first.unsolvable,
        coupling=coupling,
        notices=notices,
        warnings=first.warnings,
        source=f"scenario {scenario.name}",
    )


def _end(scenario: Scenario, until: Raw | None, period: float, h: float) -> tuple[float, tuple[str, ...]]:
    """Return the end of a run (s), rounded to whole steps of h (s), and a notice if `until` was rounded."""
    if until is None:
        return max(1, nearest_point("stop_time", scenario.end(period), h)) * h, ()
    time = quantity(until, "s", "until")
    n = nearest_steps("until", time, h)
    if is_on_grid(n, time, h):
        return n * h, ()
    deviation = f"until = {time:.12g} s is not a whole number of communication steps of {h:g} s"
    return n * h, (f"{deviation}; the run ends at {n * h:.9g} s",)


def late_changes(scenario: Scenario, until: Raw | None, period: float) -> list[tuple[Event | InputProfile, float]]:
    """Return the events of a scenario that are not before the end of the run, with their times (s)."""
    end = _asked_end(scenario, until, period)
    unnamed = tuple(event for event in scenario.event if not event.name)
    changes: tuple[Event | InputProfile, ...] = (*unnamed, *scenario.named_changes)
    return [(change, time) for change in changes if (time := change.moment(period)) >= end]


def _asked_end(scenario: Scenario, until: Raw | None, period: float) -> float:
    """Return the end of a run (s) before it is rounded to whole steps."""
    return scenario.end(period) if until is None else quantity(until, "s", "until")


def _release(
    scenario: Scenario, values: Assignments, events: Sequence[InputChange], marks: Mapping[str, float]
) -> list[InputChange]:
    """Hold the speed of a free spin, and return the change that releases it at the first event, or at cycle 0.

    If the motion settled under a drive with a limit, the run would not begin at the speed of the scenario. A changing
    speed counts as an event at cycle 0, and changes in `marks` also count as events. Scenarios that set `drive.ideal`
    are left as they are.
    """
    ideal = f"{PLANT}.{IDEAL}"
    if PLANT not in values.interfaces or IDEAL not in values.interfaces[PLANT].ports:
        return []
    if not values.parameter(f"{PLANT}.{FREE}") or ideal in values.inputs or any(e.variable == ideal for e in events):
        return []
    values.inputs[ideal] = 1.0
    moments = [*(event.time for event in events), *marks.values(), *([0.0] if scenario.speed else [])]
    return [InputChange(min(moments, default=0.0), ideal, False)]


def _with_first_angle(plan: Plan, cycles: float) -> Mapping[str, Mapping[str, float]]:
    """Return the parameters, including the start angle that makes the rotor's angle at cycle 0 exact.

    The run starts at a communication point, which is up to a step before the beginning of the settling. At cycle 0 the
    angle is the value of the parameter (0 by default) plus the settling cycles, whatever the step.
    """
    offset = plan.first + in_steps(cycles * plan.period, plan.step_size)
    parameters = {component: dict(values) for component, values in plan.parameters.items()}
    for component, interface in plan.interfaces.items():
        if offset and ANGLE in interface.ports:
            stated = parameters[component].get(ANGLE, 0.0)
            parameters[component][ANGLE] = stated + plan.inputs[SPEED] * offset * plan.step_size
    return parameters


@dataclass(frozen=True)
class ScenarioStart:
    """Start of a scenario without its events: values, warnings, and any reason why its settling must be simulated."""

    values: Assignments
    warnings: tuple[str, ...]
    unsolvable: str


def start_of(scenario: Scenario, assembly: Assembly, settings: Mapping[str, Raw] | None = None) -> ScenarioStart:
    """Return the start of a scenario; arguments and errors are those of `scenario_plan`.

    In Jacobi order, a controller that can predict displacements predicts them over the delay of the loop, unless its
    prediction time is set. Values in `settings` are refused if they are texts without a unit and far from the
    scenario's values.
    """
    values = assembly.assignments()
    with errors_in(f"scenario {scenario.name}"):
        values.set(SPEED, scenario.Omega)
        values.set_defaults_of_signals()
        stated = {*values.set_parameters(scenario.parameters)}
        for name, value in _scaled(scenario.inputs, scenario, values, "input"):
            values.set_first(name, value)
    comparison = StatedValues(scenario, {}, values)
    for name, raw in (settings or {}).items():
        stated.update(values.set(name, raw))
        if isinstance(raw, str) and (number := plain_number(raw)) is not None:
            comparison.refuse_far(name, number)
    if stators := assembly.options.get("stators", ()):
        plant_settings = [f"{PLANT}.{name}" for name in scenario.parameters.get(PLANT, ())]
        set_stators(values, stators, [*plant_settings, *(settings or ())])
    missing = MissingParameters(values, stated | stated_constants(values))
    with errors_in(f"scenario {scenario.name}"):
        of_loads = set_gravity(missing, scenario)
        warnings = [*set_operating_points(missing), *of_loads]
        set_test_force(missing)
    coupling = scenario.coupling or assembly.system.coupling
    checked_speed(values.inputs[SPEED], values.written[SPEED])  # a wrong speed is reported before a wrong step
    if late := delay(coupling, scenario.step_size(coupling)):
        for name in set(predictable(assembly.interfaces)) - stated:
            values.set(name, late)
    warnings = [*implausible_sizes(assembly), *idle_switches(values, stated), *warnings, *viscous_losses(assembly)]
    return ScenarioStart(values, tuple(warnings), unsteady_effects(values))


def _essential(places: RotorPlaces) -> tuple[str, ...]:
    """Return patterns of the variables that are always recorded, because the summary and the plots need them."""
    measured = [name for signals in places.measured.values() for name in signals]
    along = [places.thrust] if places.thrust else []
    of_places = (*(f"{bearing}.[xy]" for bearing in places.bearings), *(f"{at}.*" for at in (*places.contacts, *along)))
    return tuple(f"{PLANT}.{name}" for name in (*of_places, *measured, "contact_state", "energy.*"))


def _judged(assembly: Assembly, profiles: Sequence[Profile]) -> dict[str, OverStep | None]:
    """Return the variables that are judged at every step, and their rules over a step.

    Summaries, figures and spectra need them: contact, displacements, currents and forces of magnets, limits, and inputs
    that vary. A few of their samples would show vibrations at wrong frequencies, and would miss their extremes.
    """
    places = places_of(assembly)
    forces = ("f_n", "f_n_peak", "f_n_mean", "impulse")
    of_sites = (*forces, "mode", "whirl_speed", "race_speed", "friction_power", "heat")
    of_plant = ["contact_state", "energy.*", "speed", *(f"{at}.{name}" for at in places.contacts for name in of_sites)]
    of_plant += [f"{at}.[xy]" for at in (*places.bearings, *places.contacts)]
    if PLANT in assembly.interfaces:  # also sensors, gaps and housings
        of_plant += [port.name for port in assembly.interfaces[PLANT].of("output") if port.unit == "m"]
    result: dict[str, OverStep | None] = {f"{PLANT}.{at}.temperature": "largest" for at in places.contacts}
    of_coils = (f"{ACTUATOR}.*.{name}_?" for name in ("f", "i_upper", "i_lower", "coil_loss_upper", "coil_loss_lower"))
    of_magnets = (f"{CONTROLLER}.*.i_?", *of_coils, CONTROL_ACTS, *judged_by_stability())
    varying = (*excitations(assembly.system), *(profile.variable for profile in profiles))
    return result | dict.fromkeys((*(f"{PLANT}.{name}" for name in of_plant), *of_magnets, *varying))


def _scaled(
    variables: Mapping[str, Mapping[str, Raw]], scenario: Scenario, values: Assignments, only: str | None = None
) -> list[tuple[str, Raw]]:
    """Return names and values of inputs, even if FMUs lack them; unbalances (kg m) are scaled by the factor."""
    scaled: list[tuple[str, Raw]] = []
    for component, table in variables.items():
        for variable, raw in table.items():
            pattern = f"{component}.{variable}"
            if values.lacks(pattern, only):
                scaled.append((pattern, raw))
                continue
            for name in values.matching(pattern):
                port = values.port(name)
                if port.causality == "input" and port.unit == UNBALANCE:
                    _, value = values.read(name, raw, "input")
                    what = f"unbalance_factor times {name}"
                    scaled.append((name, convert(scenario.unbalance_factor * value, port, what)))
                else:
                    scaled.append((name, raw))
    return scaled


def _speed_profile(scenario: Scenario, values: Assignments, period: float) -> tuple[Profile, ...]:
    """Return the speed over time, if the scenario changes it."""
    if not scenario.speed:
        return ()
    signals = [signal.name for signal in values.system.signals]
    if ACCELERATION not in signals:
        raise ValueError(
            f"system {values.system.name} has no signal {ACCELERATION}, so its speed cannot change; there are "
            f"{', '.join(signals)}"
        )
    points: list[tuple[float, Any]] = [(0.0, values.inputs[SPEED])]
    points += [
        (p.moment(period), checked_speed(values.read(SPEED, p.Omega, "input")[1], p.Omega)) for p in scenario.speed
    ]
    return (Profile(SPEED, tuple(points), ACCELERATION),)


def _with_acceleration(profiles: Sequence[Profile], values: Assignments) -> tuple[Profile, ...]:
    """Return profiles in which a profile of the speed also sets the acceleration, unless another profile sets it.

    If only the speed changed, it would jump at each step, and each step would be one of constant speed.
    """
    system = values.system
    signals = [system.signal(item.variable) or system.signal_of(item.variable) for item in profiles]
    names = [None if signal is None else signal.name for signal in signals]
    if ACCELERATION in names or system.signal(ACCELERATION) is None:
        return tuple(profiles)
    return tuple(
        replace(item, slope=ACCELERATION) if name == SPEED else item for item, name in zip(profiles, names, strict=True)
    )
