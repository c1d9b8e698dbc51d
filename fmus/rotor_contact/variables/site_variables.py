"""Variables of a contact site: clearance, laws, the retainer as a body, and its contact."""

from __future__ import annotations

from fmi_export.variables import Variable, enumerated, output, parameter
from rotor_contact.variables import start_values
from rotor_contact.variables.contact_laws import CONSTRAINT, CONTACT_LAW, law_parameters
from rotor_contact.variables.enumerations import CONTACT_MODE
from rotor_contact.variables.planes import ContactSite, Planes


def site_parameters(contact: ContactSite) -> list[Variable]:
    """Return the parameters of a contact site."""
    site = contact.name
    at = f"at {site.upper()}"
    return [
        parameter(f"{site}.enabled", "1", f"Whether the rotor can touch {at}", 1.0, type="Boolean"),
        parameter(f"{site}.law", "1", f"Contact law {at}", CONSTRAINT, **enumerated(CONTACT_LAW)),
        parameter(f"{site}.clearance", "m", f"Radial clearance {at}", contact.clearance, minimum=1e-6, maximum=0.1),
        parameter(f"{site}.mu", "1", f"Coefficient of friction {at}", 0.0, minimum=0.0, maximum=10.0),
        parameter(
            f"{site}.mu_static",
            "1",
            f"Coefficient of static friction {at}; the sliding coefficient applies if larger",
            0.0,
            minimum=0.0,
            maximum=10.0,
        ),
        parameter(
            f"{site}.stribeck_velocity",
            "m/s",
            f"Slip velocity {at} over which sliding friction falls from mu_static to mu; 0: mu at any slip",
            0.0,
            minimum=0.0,
            maximum=1e3,
        ),
        parameter(
            f"{site}.restitution",
            "1",
            f"Coefficient of restitution {at}, of the newton impact law",
            0.0,
            minimum=0.0,
            maximum=1.0,
        ),
        parameter(
            f"{site}.journal_radius", "m", f"Journal radius {at}", contact.journal_radius, minimum=0.0, maximum=10.0
        ),
        parameter(f"{site}.offset_x", "m", f"Centre of the clearance in x {at}", 0.0),
        parameter(f"{site}.offset_y", "m", f"Centre of the clearance in y {at}", 0.0),
        *law_parameters(site),
        *_retainer_parameters(site, at),
    ]


def _retainer_parameters(site: str, at: str) -> list[Variable]:
    """Return the parameters of a retainer as a body: housing on a mount, race, and temperature."""
    not_negative = {"minimum": 0.0, "maximum": 1e12}
    return [
        parameter(f"{site}.housing_mass", "kg", f"Mass of the retainer's housing {at}; 0: fixed", 0.0, **not_negative),
        *(
            parameter(
                f"{site}.mount_stiffness_{axis}", "N/m", f"Stiffness of its mount {at} in {axis}", 0.0, **not_negative
            )
            for axis in "xy"
        ),
        *(
            parameter(
                f"{site}.mount_damping_{axis}", "N.s/m", f"Damping of its mount {at} in {axis}", 0.0, **not_negative
            )
            for axis in "xy"
        ),
        parameter(
            f"{site}.race_inertia",
            "kg.m2",
            f"Polar inertia of the rotating parts of the retainer {at}, race and rolling elements; 0: none",
            0.0,
            **not_negative,
        ),
        parameter(f"{site}.race_drag", "N.m", f"Constant drag on the race {at}", 0.0, **not_negative),
        parameter(f"{site}.race_viscous_drag", "N.m.s", f"Viscous drag on the race {at}", 0.0, **not_negative),
        parameter(
            f"{site}.heat_capacity",
            "J/K",
            f"Heat capacity of the retainer {at}; 0: constant temperature",
            0.0,
            **not_negative,
        ),
        parameter(
            f"{site}.heat_transfer",
            "W/K",
            f"Heat flow to the surroundings per temperature difference {at}",
            0.0,
            **not_negative,
        ),
        parameter(f"{site}.temperature_limit", "K", f"Allowed temperature {at}", 393.15, **not_negative),
    ]


def site_outputs(site: str, planes: Planes) -> list[Variable]:
    """Return the outputs of a contact site of a rotor with these planes.

    `start_values` lists the dependencies of initial values; () marks a value that is the same at every start.
    """
    at = f"at {site.upper()}"
    journal = start_values.journal(planes, site)
    forces = start_values.forces(planes)
    return [
        *(
            output(
                f"{site}.{axis}",
                "m",
                f"Displacement of the journal from the centre of the retainer {at} in {axis}",
                initially_depends_on=journal,
                display_unit="um",
            )
            for axis in "xy"
        ),
        output(
            f"{site}.gap",
            "m",
            f"Remaining clearance {at}, zero in contact, negative in compliant contact",
            initially_depends_on=journal,
            display_unit="um",
        ),
        output(
            f"{site}.mode",
            "1",
            f"Mode of contact {at}",
            initially_depends_on=forces,
            **enumerated(CONTACT_MODE),
        ),
        output(f"{site}.f_n", "N", f"Normal contact force {at}, inward on the rotor", initially_depends_on=forces),
        output(
            f"{site}.f_n_peak",
            "N",
            f"Largest normal contact force {at} during the last communication step, without impact impulses",
            initially_depends_on=forces,
            over_step="largest",
        ),
        output(
            f"{site}.f_n_mean",
            "N",
            f"Mean of the normal contact force {at} over the last communication step, including impact impulses "
            f"(whose mean grows as steps get shorter)",
            initially_depends_on=(),
            over_step="mean",
        ),
        output(
            f"{site}.f_t",
            "N",
            f"Friction force on the rotor {at}, forward (in the direction of spin) positive",
            initially_depends_on=forces,
        ),
        output(
            f"{site}.impulse",
            "N.s",
            f"Normal impulse of the impacts {at} during the last communication step, conserving momentum; the sum "
            f"over steps does not depend on the step size",
            initially_depends_on=(),
            over_step="sum",
        ),
        output(
            f"{site}.slip_velocity",
            "m/s",
            f"Velocity of the journal surface relative to the retainer {at}",
            initially_depends_on=start_values.slip(planes, site),
        ),
        output(
            f"{site}.whirl_speed",
            "rad/s",
            f"Whirl speed about the centre of the clearance {at}",
            initially_depends_on=journal,
        ),
        *(
            output(
                f"{site}.housing_{axis}",
                "m",
                f"Displacement of the retainer's housing {at} in {axis}",
                initially_depends_on=(),
                display_unit="um",
            )
            for axis in "xy"
        ),
        output(
            f"{site}.race_speed",
            "rad/s",
            f"Speed of the race {at}, positive in the direction of spin",
            initially_depends_on=(),
        ),
        output(
            f"{site}.friction_power",
            "W",
            f"Heat flow of sliding friction {at}",
            initially_depends_on=start_values.sliding(planes),
        ),
        output(f"{site}.heat", "J", f"Heat of friction, race drag and impacts {at}", initially_depends_on=()),
        output(f"{site}.temperature", "K", f"Temperature of the retainer {at}", initially_equals="ambient_temperature"),
        output(
            f"{site}.passed",
            "1",
            f"Whether the rotor is beyond the clearance {at} while enabled is false, so that it cannot touch",
            type="Boolean",
            initially_depends_on=journal,
            warning=f"{site.upper()} is switched off ({site}.enabled = false); the rotor would have touched it (gap "
            f"{{{site}.gap}} m, negative beyond the clearance of {{{site}.clearance}} m)",
        ),
        output(
            f"{site}.beyond_reduction",
            "1",
            f"Whether the rotor whirls in contact {at} faster than the frequency up to which the rotor's reduction is "
            f"accurate",
            type="Boolean",
            initially_depends_on=start_values.sliding_contact(planes),
            warning=f"the whirl in contact at {site.upper()}, {{{site}.whirl_speed}} rad/s, is faster than "
            "the frequency up to which the rotor's reduction is accurate: retain more planes or modes",
        ),
        output(
            f"{site}.overheated",
            "1",
            f"Whether the retainer exceeds its temperature_limit {at}",
            type="Boolean",
            initially_depends_on=("ambient_temperature", f"{site}.temperature_limit"),
            warning=f"{site}.temperature = {{{site}.temperature}} K exceeds {site}.temperature_limit = "
            f"{{{site}.temperature_limit}} K",
        ),
    ]
