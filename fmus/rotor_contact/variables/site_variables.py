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
        parameter(f"{site}.enabled", "1", f"Whether the rotor can make contact {at}", 1.0, type="Boolean"),
        parameter(f"{site}.law", "1", f"Contact law {at}", CONSTRAINT, **enumerated(CONTACT_LAW)),
        parameter(f"{site}.clearance", "m", f"Radial clearance {at}", contact.clearance, minimum=1e-6, maximum=0.1),
        parameter(f"{site}.mu", "1", f"Coefficient of friction {at}", 0.0, minimum=0.0, maximum=10.0),
        parameter(
            f"{site}.mu_static",
            "1",
            f"Coefficient of static friction {at}, or mu if that is larger",
            0.0,
            minimum=0.0,
            maximum=10.0,
        ),
        parameter(
            f"{site}.stribeck_velocity",
            "m/s",
            f"Slip velocity {at} over which sliding friction falls from mu_static to mu, or 0 for mu at any slip",
            0.0,
            minimum=0.0,
            maximum=1e3,
        ),
        parameter(
            f"{site}.restitution",
            "1",
            f"Coefficient of restitution {at}, used by the newton impact law",
            0.0,
            minimum=0.0,
            maximum=1.0,
        ),
        parameter(
            f"{site}.journal_radius",
            "m",
            f"Radius of the journal {at}",
            contact.journal_radius,
            minimum=0.0,
            maximum=10.0,
        ),
        parameter(f"{site}.offset_x", "m", f"Position of the centre of the clearance {at} in x", 0.0),
        parameter(f"{site}.offset_y", "m", f"Position of the centre of the clearance {at} in y", 0.0),
        *law_parameters(site),
        *_retainer_parameters(site, at),
    ]


def _retainer_parameters(site: str, at: str) -> list[Variable]:
    """Return the parameters of a retainer as a body: housing on a mount, race, and temperature."""
    not_negative = {"minimum": 0.0, "maximum": 1e12}
    return [
        parameter(
            f"{site}.housing_mass",
            "kg",
            f"Mass of the housing of the retainer {at}, or 0 for a fixed housing",
            0.0,
            **not_negative,
        ),
        *(
            parameter(
                f"{site}.mount_stiffness_{axis}",
                "N/m",
                f"Stiffness of the mount of the housing {at} in {axis}",
                0.0,
                **not_negative,
            )
            for axis in "xy"
        ),
        *(
            parameter(
                f"{site}.mount_damping_{axis}",
                "N.s/m",
                f"Damping of the mount of the housing {at} in {axis}",
                0.0,
                **not_negative,
            )
            for axis in "xy"
        ),
        parameter(
            f"{site}.race_inertia",
            "kg.m2",
            f"Polar moment of inertia of the race and rolling elements {at}, or 0 for a race that does not rotate",
            0.0,
            **not_negative,
        ),
        parameter(f"{site}.race_drag", "N.m", f"Constant drag torque on the race {at}", 0.0, **not_negative),
        parameter(
            f"{site}.race_viscous_drag",
            "N.m.s",
            f"Coefficient of the viscous drag on the race {at}",
            0.0,
            **not_negative,
        ),
        parameter(
            f"{site}.heat_capacity",
            "J/K",
            f"Heat capacity of the retainer {at}, or 0 for a constant temperature",
            0.0,
            **not_negative,
        ),
        parameter(
            f"{site}.heat_transfer",
            "W/K",
            f"Heat flow from the retainer {at} to the surroundings per temperature difference",
            0.0,
            **not_negative,
        ),
        parameter(
            f"{site}.temperature_limit",
            "K",
            f"Highest allowed temperature of the retainer {at}",
            393.15,
            **not_negative,
        ),
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
                f"Displacement of the journal {at} in {axis} from the centre of the retainer",
                initially_depends_on=journal,
                display_unit="um",
            )
            for axis in "xy"
        ),
        output(
            f"{site}.gap",
            "m",
            f"Remaining clearance {at}, which is zero in rigid contact and negative in compliant contact",
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
        output(
            f"{site}.f_n", "N", f"Normal contact force on the rotor {at}, positive inward", initially_depends_on=forces
        ),
        output(
            f"{site}.f_n_peak",
            "N",
            f"Largest normal contact force {at} during the last communication step, without the impulses of impacts",
            initially_depends_on=forces,
            over_step="largest",
        ),
        output(
            f"{site}.f_n_mean",
            "N",
            f"Mean normal contact force {at} over the last communication step, including the impulses of impacts, "
            f"whose contribution grows as steps get shorter",
            initially_depends_on=(),
            over_step="mean",
        ),
        output(
            f"{site}.f_t",
            "N",
            f"Friction force on the rotor {at}, positive in the direction of positive spin",
            initially_depends_on=forces,
        ),
        output(
            f"{site}.impulse",
            "N.s",
            f"Normal impulse of the impacts {at} during the last communication step, as the conservation of momentum "
            f"requires it",
            initially_depends_on=(),
            over_step="sum",
        ),
        output(
            f"{site}.slip_velocity",
            "m/s",
            f"Velocity of the journal surface relative to the retainer {at}, positive in the direction of positive "
            f"spin",
            initially_depends_on=start_values.slip(planes, site),
        ),
        output(
            f"{site}.whirl_speed",
            "rad/s",
            f"Whirl speed of the journal about the centre of the retainer {at}, positive in the direction of positive "
            f"spin",
            initially_depends_on=journal,
        ),
        *(
            output(
                f"{site}.housing_{axis}",
                "m",
                f"Displacement of the housing of the retainer {at} in {axis}",
                initially_depends_on=(),
                display_unit="um",
            )
            for axis in "xy"
        ),
        output(
            f"{site}.race_speed",
            "rad/s",
            f"Speed of the race {at}, positive in the direction of positive spin",
            initially_depends_on=(),
        ),
        output(
            f"{site}.friction_power",
            "W",
            f"Heat flow of sliding friction {at}",
            initially_depends_on=start_values.sliding(planes),
        ),
        output(
            f"{site}.heat",
            "J",
            f"Heat so far from friction, race drag, impacts and compression in the retainer {at}, including that of a "
            f"face on this retainer",
            initially_depends_on=(),
        ),
        output(f"{site}.temperature", "K", f"Temperature of the retainer {at}", initially_equals="ambient_temperature"),
        output(
            f"{site}.passed",
            "1",
            f"Whether the rotor is beyond the clearance {at} without contact, because {site}.enabled is false",
            type="Boolean",
            initially_depends_on=journal,
            warning=f"{site.upper()} is switched off ({site}.enabled = false); the rotor would have touched it (gap "
            f"{{{site}.gap}} m, negative beyond the clearance of {{{site}.clearance}} m)",
        ),
        output(
            f"{site}.beyond_reduction",
            "1",
            f"Whether the rotor whirls in contact {at} faster than the frequency up to which its reduced model is "
            f"accurate",
            type="Boolean",
            initially_depends_on=start_values.sliding_contact(planes),
            warning=f"the whirl in contact at {site.upper()}, {{{site}.whirl_speed}} rad/s, is faster than "
            "the frequency up to which the rotor's reduction is accurate: retain more planes or modes",
        ),
        output(
            f"{site}.overheated",
            "1",
            f"Whether the temperature of the retainer {at} exceeds {site}.temperature_limit",
            type="Boolean",
            initially_depends_on=("ambient_temperature", f"{site}.temperature_limit"),
            warning=f"{site}.temperature = {{{site}.temperature}} K exceeds {site}.temperature_limit = "
            f"{{{site}.temperature_limit}} K",
        ),
    ]
