"""The rotor of a run, for the analysis of steady rub: loop, contact sites, friction and unbalance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from amb_analysis.machine.machine import Machine, machine_of
from amb_analysis.steady_contact.forward_loop import Complex, ForwardLoop, forward_loop, mixing
from amb_analysis.steady_contact.receptances import Receptances, receptances
from amb_analysis.steady_contact.stability import Dynamics
from amb_cosim.model_constants.plant_data import stator_bores
from amb_cosim.results.component_names import CONTROLLER, PLANT
from amb_cosim.results.places import limit_of
from amb_cosim.scenario.plan import ScenarioPlan
from array_types import Array
from rotor_contact.contact.friction import kinetic_coefficient
from rotor_contact.contact.site import SITE, Site
from rotor_contact.variables.contact_laws import CONSTRAINT, LAWS
from rotor_contact.variables.signals import SITE_PARAMETERS

ISOTROPIC = 0.01  # ratio of backward to forward motion above which a loop is reported as anisotropic
SLIP_STEP = 1e-6  # m/s, over which the slope of friction is taken


@dataclass(frozen=True, eq=False)
class RubbingRotor:
    """A machine with contact sites.

    machine
        The machine.
    sites
        Names of the enabled sites.
    records
        Parameters of these sites, as records that the kernels of `rotor_contact` read.
    c
        Clearances of these sites (m), shape (n_sites,).
    unbalance
        Complex unbalance (kg m) at each place, shape (n_places,).
    notes
        Sentences about the approximations.
    """

    machine: Machine
    sites: tuple[str, ...]
    records: tuple[Site, ...]
    c: Array
    unbalance: Complex
    notes: tuple[str, ...]
    _loops: dict[float, ForwardLoop] = field(default_factory=dict)
    _receptances: dict[float, Receptances] = field(default_factory=dict)
    _dynamics: dict[float, Dynamics] = field(default_factory=dict)

    @property
    def Omega(self) -> float:
        """Spin speed of the run (rad/s)."""
        return self.machine.Omega

    @property
    def parameters(self) -> Mapping[str, float]:
        """Parameters of the plant (SI)."""
        return self.machine.parameters[PLANT]

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places of unbalance."""
        return tuple(self.machine.unbalance)

    @property
    def valid_to(self) -> float:
        """Frequency (rad/s) up to which the reduced rotor is accurate; infinite without a limit."""
        return limit_of(self.machine.run_components.layout(PLANT)) or math.inf

    def loop(self, Omega: float) -> ForwardLoop:
        """Return the loop of forward motion at a speed (rad/s)."""
        if Omega not in self._loops:
            self._loops[Omega] = forward_loop(self.machine.run_components, Omega, self.sites)
        return self._loops[Omega]

    def receptances(self, Omega: float) -> Receptances:
        """Return the receptances at a speed (rad/s)."""
        if Omega not in self._receptances:
            self._receptances[Omega] = receptances(self.loop(Omega))
        return self._receptances[Omega]

    def dynamics(self, Omega: float) -> Dynamics:
        """Return the small motion about synchronous states at a speed (rad/s)."""
        if Omega not in self._dynamics:
            self._dynamics[Omega] = Dynamics(self.loop(Omega), self.c, self.mu(Omega), self.mu_slope(Omega))
        return self._dynamics[Omega]

    def mu(self, Omega: float, whirl: float | None = None) -> Array:
        """Return the friction coefficient mu(v) of each site by the law of `rotor_contact.contact.friction`.

        The slip velocity of a journal that whirls on its circle is v = Omega R_s + omega c (4.10).

        Parameters
        ----------
        Omega
            Spin speed (rad/s).
        whirl
            Whirl frequency omega (rad/s); the spin speed by default.
        """
        return np.array([kinetic_coefficient(site, _slip(site, Omega, whirl)) for site in self.records])

    def mu_slope(self, Omega: float, whirl: float | None = None) -> Array:
        """Return the slope d mu/d v (s/m) of the friction coefficient, from a central difference over `SLIP_STEP`."""
        slopes = np.zeros(len(self.records))
        for k, site in enumerate(self.records):
            slip = _slip(site, Omega, whirl)
            low, high = slip - SLIP_STEP, slip + SLIP_STEP
            slopes[k] = (kinetic_coefficient(site, high) - kinetic_coefficient(site, low)) / (high - low)
        return slopes


def rubbing_rotor(prepared: ScenarioPlan) -> RubbingRotor:
    """Return the rotor of a prepared run, with its final unbalance.

    Sites are treated as rigid, fixed and centred. If several sites are in one plane, the rotor can therefore touch only
    the narrowest.

    Raises
    ------
    ValueError
        If the run has no `rotor_contact`, or none of its sites is enabled.
    """
    machine = machine_of(prepared)
    source, p = machine.run_components, machine.parameters[PLANT]
    enabled = [site["name"] for site in source.layout(PLANT)["sites"] if p[f"{site['name']}.enabled"]]
    if not enabled:
        raise ValueError(f"scenario {prepared.name} has no enabled site; a rub needs one")
    bores = stator_bores(machine.rotor, [bearing.name for bearing in machine.rotor.bearings])
    nodes = {site.name: site.node for site in (*machine.rotor.sites, *bores)}
    narrowest: dict[int, str] = {}
    for site in sorted(enabled, key=lambda name: p[f"{name}.clearance"]):
        narrowest.setdefault(nodes[site], site)
    sites = tuple(site for site in enabled if narrowest[nodes[site]] == site)
    records = tuple(_record(p, site) for site in sites)
    c = np.array([site.clearance for site in records])
    covered = tuple(
        f"{s} is left out; {narrowest[nodes[s]]} in the same plane has the same or a smaller clearance"
        for s in enabled
        if s not in sites
    )
    notes = covered + _site_notes(p, sites) + _loop_notes(machine, mixing(source, machine.last_speed, sites))
    return RubbingRotor(machine, sites, records, c, np.array(list(machine.unbalance.values()), dtype=complex), notes)


def _record(p: Mapping[str, float], name: str) -> Site:
    """Return the parameters of a site as a record."""
    site: Site = np.zeros(1, SITE)[0]
    for field_name in SITE_PARAMETERS.names or ():
        site[field_name] = p[f"{name}.{field_name}"]
    return site


def _slip(site: Site, Omega: float, whirl: float | None) -> float:
    """Return the slip velocity v (m/s) of a journal that whirls on its clearance circle."""
    return float(Omega * site.journal_radius + (Omega if whirl is None else whirl) * site.clearance)


def _site_notes(p: Mapping[str, float], sites: tuple[str, ...]) -> tuple[str, ...]:
    result = []
    for site in sites:
        if p[f"{site}.law"] != CONSTRAINT:
            result.append(f"{site} is assumed to be rigid, although its law is {LAWS[int(p[f'{site}.law'])]}")
        if p[f"{site}.housing_mass"] > 0.0:
            result.append(f"{site} is assumed to be fixed, although its housing moves")
        if p[f"{site}.race_inertia"] > 0.0:
            result.append(f"the race of {site} is assumed to be at rest, although it can turn")
        if p[f"{site}.offset_x"] != 0.0 or p[f"{site}.offset_y"] != 0.0:
            offset = ", ".join(f"{p[f'{site}.offset_{axis}']:g}" for axis in "xy")
            result.append(f"{site} is assumed to be centred, although it is offset by {offset} m")
    if p["spin.free"]:
        result.append("the spin speed is assumed to be constant, although friction brakes it in a run")
    if p["gravity"] != 0.0:
        result.append("weight is neglected: the rotor is assumed to be centred")
    return tuple(result)


def _loop_notes(machine: Machine, backward: float) -> tuple[str, ...]:
    inputs, result = machine.last_inputs, list[str]()
    if faults := machine.faults_among(inputs):
        result.append(
            f"states are computed without the faults that are active at the end of the scenario: {', '.join(faults)}"
        )
    if backward > ISOTROPIC:
        result.append(f"the loop is anisotropic: {backward:.1%} of the motion is backward, which is neglected")
    if inputs.get(f"{CONTROLLER}.rolac_enable"):
        result.append(
            "states are computed with the feedback alone; the effect of synchronous control is listed separately"
        )
    return tuple(result)
