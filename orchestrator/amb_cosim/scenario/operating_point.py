"""A controller's assumptions about the magnets: K_s, K_i and the range of currents at their operating points."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from amb_cosim.results.magnet_limits import coil_limits

LARGEST_RATIO = 1.5  # between an assumed constant and the magnet's, or its inverse, without a warning or a change
MOST_NAMED = 4  # in a warning
MEASURED = "k_s_measured", "k_i_measured"
GEOMETRY = "turns", "pole_area", "gap", "half_angle", "bias_current"
TEST_FORCE = f"{CONTROLLER}.identification.force_scale"
LINEAR = 0  # of force_law: constants from the geometry


@dataclass(frozen=True)
class MissingParameters:
    """Values of parameters; those not in `stated` may still be set."""

    values: Assignments
    stated: Collection[str]

    def set(self, name: str, value: Raw) -> None:
        """Set a parameter unless the user has set it."""
        if name not in self.stated:
            self.values.set_or_drop(name, value, only="parameter")


def stated_constants(values: Assignments, component: str = CONTROLLER) -> set[str]:
    """Return the parameters of a component that a system file states itself and does not inherit."""
    stated = [f"{component}.{pattern}" for pattern in values.system.stated.get(component, ())]
    return {name for pattern in stated if not values.lacks(pattern) for name in values.matching(pattern)}


def set_operating_points(missing: MissingParameters) -> list[str]:
    """Set the controller's assumptions about each magnet: K_s, K_i, i_min and i_max; return warnings.

    The currents i_min and i_max are the ones that the coils allow (`coil_limits`), because the integral part of a PID
    controller would wind up beyond the range of the actuator. K_s and K_i are the slopes of the magnet's force law at
    its centre. A warning names settings that differ from these slopes by more than a factor of `LARGEST_RATIO`. If only
    a geometry is set, it also names measured constants that differ by as much from the constants that follow from the
    geometry.

    Parameters
    ----------
    missing
        The values of all parameters, and the names of those that are set or fixed.
    """
    values, differences = missing.values, list[str]()
    for bearing, axis in magnet_axes(values):
        p, law = parameters_of(values, bearing, axis), values.parameter(f"{ACTUATOR}.force_law")
        low, high = coil_limits(p)
        if not low <= 0.0 <= high:
            continue  # the actuator refuses to start with it
        measured = is_measured(values)
        slopes = tuple(p[name] for name in MEASURED) if measured else _slopes(bearing, axis, p, int(law))
        assumed = {f"{CONTROLLER}.{bearing}.{name}_{axis}": k for name, k in zip(("k_s", "k_i"), slopes, strict=True)}
        currents = {"i_min": low, "i_max": high}
        for name, value in (assumed | {f"{CONTROLLER}.{bearing}.{n}_{axis}": i for n, i in currents.items()}).items():
            _set_assumption(missing, name, value)
        geometry = {f"{ACTUATOR}.{bearing}.{name}_{axis}" for name in GEOMETRY}
        constants = {f"{ACTUATOR}.{bearing}.{name}_{axis}": k for name, k in zip(MEASURED, slopes, strict=True)}
        if measured and geometry & {*missing.stated} and not constants.keys() & {*missing.stated}:
            assumed |= dict(zip(constants, _slopes(bearing, axis, p, LINEAR), strict=True))
        differences += [sentence for name, value in assumed.items() if (sentence := _difference(values, name, value))]
    about = f"by more than a factor of {LARGEST_RATIO:g} from the values of the magnets"
    more = [f"and {len(differences) - MOST_NAMED} more"] if len(differences) > MOST_NAMED else []
    return [f"constants differ {about}: {'; '.join(differences[:MOST_NAMED] + more)}"] if differences else []


def set_test_force(missing: MissingParameters) -> None:
    """Scale the test force of identification by the ratio of the magnets' force to that of the actuator's start values.

    A(f) of `rolac_controller.excitation` suits magnets with the actuator's start values. For other magnets, a test
    force in proportion to

        K_i I_b = k I_b^2/s_0^2,    k = 4 mu_0 N^2 A cos(phi)                                        (1)

    without static load, uses the same share of their currents and of their gap, because K_s is about K_i I_b/s_0. The
    axis with the smallest ratio determines the test force. If the magnets are measured, K_i is the measured constant.
    A(f) is not changed if the two forces differ by less than a factor of `LARGEST_RATIO`.

    Parameters
    ----------
    missing
        The values of all parameters, and the names of those that are set or fixed.
    """
    values, shares = missing.values, list[float]()
    measured = {MEASURED[1], "bias_current", "static_current"}
    for bearing, axis in magnet_axes(values):
        own = parameters_of(values, bearing, axis)
        start = {name: values.interfaces[ACTUATOR].ports[f"{bearing}.{name}_{axis}"].start or 0.0 for name in own}
        if not (measured if is_measured(values) else {*GEOMETRY, "static_current"}) <= own.keys():
            return
        largest, of_start = (_test_range(p, measured=is_measured(values)) for p in (own, start))
        if not largest > 0.0 or not of_start > 0.0:
            return
        shares.append(largest / of_start)
    if shares and not 1.0 / LARGEST_RATIO <= min(shares) <= LARGEST_RATIO:
        _set_assumption(missing, TEST_FORCE, min(shares))


def _test_range(of_axis: Mapping[str, float], *, measured: bool) -> float:
    """Return (1)/(4 mu_0) for an axis, or K_i I_b if K_i is measured; I_b is the current of the unloaded coil."""
    bias = of_axis["bias_current"] + min(of_axis["static_current"], 0.0)
    if measured:
        return of_axis[MEASURED[1]] * bias
    k = of_axis["turns"] ** 2 * of_axis["pole_area"] * math.cos(of_axis["half_angle"])
    return k * math.copysign(bias**2, bias) / of_axis["gap"] ** 2


def is_measured(values: Assignments) -> bool:
    """Return whether the magnets use measured constants, which do not follow from geometry and currents."""
    law = values.parameter(f"{ACTUATOR}.force_law")
    return law == values.interfaces[ACTUATOR].ports["force_law"].items.get("measured")


def parameters_of(values: Assignments, bearing: str, axis: str) -> dict[str, float]:
    """Return the actuator's parameters for an axis by their names, without the bearing and the axis."""
    prefix, suffix, stated = f"{bearing}.", f"_{axis}", values.parameters[ACTUATOR]
    return {
        port.name.removeprefix(prefix).removesuffix(suffix): stated.get(port.name, port.start or 0.0)
        for port in values.interfaces[ACTUATOR].matching(f"{prefix}*{suffix}")
        if port.causality == "parameter"
    }


def magnet_axes(values: Assignments) -> Iterator[tuple[str, str]]:
    """Yield the bearing and axis of each magnet if there are a controller and an actuator with a force law."""
    if {ACTUATOR, CONTROLLER} <= values.interfaces.keys() and "force_law" in values.interfaces[ACTUATOR].ports:
        for port in values.interfaces[ACTUATOR].matching(f"*.{MEASURED[0]}_?"):
            yield port.name.rpartition(".")[0], port.name[-1]


def _slopes(bearing: str, axis: str, of_axis: Mapping[str, float], law: int) -> tuple[float, float]:
    """Return K_s (N/m) and K_i (N/A) of a magnet according to a force law."""
    from amb_cosim.model_constants.magnetic_bearing import (  # measured ones need no scipy
        axis_parameters,
        operating_constants,
    )

    return operating_constants(axis_parameters(bearing, axis, **of_axis), law)


def _set_assumption(missing: MissingParameters, name: str, value: float) -> None:
    """Set a parameter of the controller unless the user has set it, the controller lacks it or already has the value.

    Raises
    ------
    ValueError
        If the controller does not allow the value; any other value would be an assumption about another magnet.
    """
    port = missing.values.interfaces[CONTROLLER].ports.get(name.removeprefix(f"{CONTROLLER}."))
    if port is None or name in missing.stated or math.isclose(missing.values.parameter(name), value):
        return
    if not port.minimum <= value <= port.maximum:
        unit = port.display_unit
        raise ValueError(
            f"{name} = {value:.4g}{unit}, which follows from the magnets, is not allowed; the controller requires "
            f"{port.allowed()}: change the magnets in {ACTUATOR}, or set {name}"
        )
    missing.set(name, value)


def _difference(values: Assignments, name: str, of_magnet: float) -> str:
    """Return a phrase that states a parameter and the magnet's value if they differ much; otherwise an empty text."""
    component, _, variable = name.partition(".")
    port = values.interfaces[component].ports.get(variable)
    if port is None:
        return ""
    stated = values.parameter(name)
    least, most = sorted((stated / LARGEST_RATIO, stated * LARGEST_RATIO))
    if least <= of_magnet <= most:
        return ""
    return f"{name} = {stated:.4g}{port.display_unit}, but {of_magnet:.4g}{port.display_unit} according to the magnet"
