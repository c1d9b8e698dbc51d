"""Variables of a contact site: clearance, laws, the retainer as a body, and its contact."""

from __future__ import annotations

from fmi_export.variables import Variable, at_place, enumerated
from rotor_contact.variables import start_values
from rotor_contact.variables.contact_laws import CONSTRAINT, CONTACT_LAW, law_parameters
from rotor_contact.variables.enumerations import CONTACT_MODE
from rotor_contact.variables.planes import ContactSite, Planes
from rotor_contact.variables.start_values import ALWAYS_SAME

COEFFICIENT = {"minimum": 0.0, "maximum": 10.0}
NOT_NEGATIVE = {"minimum": 0.0, "maximum": 1e12}


def site_parameters(contact: ContactSite) -> list[Variable]:
    """Return the parameters of a contact site: clearance, laws, and the retainer as a body."""
    declare, *_ = at_place(f"{contact.name}.{{}}", f"at {contact.name.upper()}")
    return [
        declare("enabled", "1", "Whether the rotor can make contact {}", 1.0, type="Boolean"),
        declare("law", "1", "Contact law {}", CONSTRAINT, **enumerated(CONTACT_LAW)),
        declare("clearance", "m", "Radial clearance {}", contact.clearance, minimum=1e-6, maximum=0.1),
        declare("mu", "1", "Coefficient of friction {}", 0.0, **COEFFICIENT),
        declare("mu_static", "1", "Coefficient of static friction {}, or mu if that is larger", 0.0, **COEFFICIENT),
        declare(
            "stribeck_velocity",
            "m/s",
            "Slip velocity {} over which sliding friction falls from mu_static to mu, or 0 for mu at any slip",
            0.0,
            minimum=0.0,
            maximum=1e3,
        ),
        declare(
            "restitution",
            "1",
            "Coefficient of restitution {}, used by the newton impact law",
            0.0,
            minimum=0.0,
            maximum=1.0,
        ),
        declare("journal_radius", "m", "Radius of the journal {}", contact.journal_radius, minimum=0.0, maximum=10.0),
        *(
            declare(f"offset_{axis}", "m", f"Position of the centre of the clearance {{}} in {axis}", 0.0)
            for axis in "xy"
        ),
        *law_parameters(declare),
        declare(
            "housing_mass",
            "kg",
            "Mass of the housing of the retainer {}, or 0 for a fixed housing",
            0.0,
            **NOT_NEGATIVE,
        ),
        *(
            declare(
                f"mount_{what}_{axis}",
                unit,
                f"{what.capitalize()} of the mount of the housing {{}} in {axis}",
                0.0,
                **NOT_NEGATIVE,
            )
            for what, unit in (("stiffness", "N/m"), ("damping", "N.s/m"))
            for axis in "xy"
        ),
        declare(
            "race_inertia",
            "kg.m2",
            "Polar moment of inertia of the race and rolling elements {}, or 0 for a race that does not rotate",
            0.0,
            **NOT_NEGATIVE,
        ),
        declare("race_drag", "N.m", "Constant drag torque on the race {}", 0.0, **NOT_NEGATIVE),
        declare("race_viscous_drag", "N.m.s", "Coefficient of the viscous drag on the race {}", 0.0, **NOT_NEGATIVE),
        declare(
            "heat_capacity",
            "J/K",
            "Heat capacity of the retainer {}, or 0 for a constant temperature",
            0.0,
            **NOT_NEGATIVE,
        ),
        declare(
            "heat_transfer",
            "W/K",
            "Heat flow from the retainer {} to the surroundings per temperature difference",
            0.0,
            **NOT_NEGATIVE,
        ),
        declare("temperature_limit", "K", "Highest allowed temperature of the retainer {}", 393.15, **NOT_NEGATIVE),
    ]


def site_outputs(site: str, planes: Planes) -> list[Variable]:
    """Return the outputs of a contact site of a rotor with these planes."""
    *_, declare = at_place(f"{site}.{{}}", f"at {site.upper()}")
    journal = {"initially_depends_on": start_values.journal(planes, site)}
    forces = {"initially_depends_on": start_values.forces(planes)}
    spin = "positive in the direction of positive spin"
    return [
        *(
            declare(
                axis,
                "m",
                f"Displacement of the journal {{}} in {axis} from the centre of the retainer",
                **journal,
                display_unit="um",
            )
            for axis in "xy"
        ),
        declare(
            "gap",
            "m",
            "Remaining clearance {}, which is zero in rigid contact and negative in compliant contact",
            **journal,
            display_unit="um",
        ),
        declare("mode", "1", "Mode of contact {}", **forces, **enumerated(CONTACT_MODE)),
        declare("f_n", "N", "Normal contact force on the rotor {}, positive inward", **forces),
        declare(
            "f_n_peak",
            "N",
            "Largest normal contact force {} during the last communication step, without the impulses of impacts",
            over_step="largest",
            **forces,
        ),
        declare(
            "f_n_mean",
            "N",
            "Mean normal contact force {} over the last communication step, including the impulses of impacts, whose "
            "contribution grows as steps get shorter",
            over_step="mean",
            **ALWAYS_SAME,
        ),
        declare("f_t", "N", f"Friction force on the rotor {{}}, {spin}", **forces),
        declare(
            "impulse",
            "N.s",
            "Normal impulse of the impacts {} during the last communication step, as the conservation of momentum "
            "requires it",
            over_step="sum",
            **ALWAYS_SAME,
        ),
        declare(
            "slip_velocity",
            "m/s",
            f"Velocity of the journal surface relative to the retainer {{}}, {spin}",
            initially_depends_on=start_values.slip(planes, site),
        ),
        declare(
            "whirl_speed",
            "rad/s",
            f"Whirl speed of the journal about the centre of the retainer {{}}, {spin}",
            **journal,
        ),
        *(
            declare(
                f"housing_{axis}",
                "m",
                f"Displacement of the housing of the retainer {{}} in {axis}",
                **ALWAYS_SAME,
                display_unit="um",
            )
            for axis in "xy"
        ),
        declare("race_speed", "rad/s", f"Speed of the race {{}}, {spin}", **ALWAYS_SAME),
        declare(
            "friction_power", "W", "Heat flow of sliding friction {}", initially_depends_on=start_values.sliding(planes)
        ),
        declare(
            "heat",
            "J",
            "Heat so far from friction, race drag, impacts and compression in the retainer {}, including that of a "
            "face on this retainer",
            **ALWAYS_SAME,
        ),
        declare("temperature", "K", "Temperature of the retainer {}", initially_equals="ambient_temperature"),
        declare(
            "passed",
            "1",
            f"Whether the rotor is beyond the clearance {{}} without contact, because {site}.enabled is false",
            type="Boolean",
            warning=f"{site.upper()} is switched off ({site}.enabled = false); the rotor would have touched it (gap "
            f"{{{site}.gap}} m, negative beyond the clearance of {{{site}.clearance}} m)",
            **journal,
        ),
        declare(
            "beyond_reduction",
            "1",
            "Whether the rotor whirls in contact {} faster than the frequency up to which its reduced model is "
            "accurate",
            type="Boolean",
            initially_depends_on=start_values.sliding_contact(planes),
            warning=f"the whirl in contact at {site.upper()}, {{{site}.whirl_speed}} rad/s, is faster than "
            "the frequency up to which the rotor's reduction is accurate: retain more planes or modes",
        ),
        declare(
            "overheated",
            "1",
            f"Whether the temperature of the retainer {{}} exceeds {site}.temperature_limit",
            type="Boolean",
            initially_depends_on=("ambient_temperature", f"{site}.temperature_limit"),
            warning=f"{site}.temperature = {{{site}.temperature}} K exceeds {site}.temperature_limit = "
            f"{{{site}.temperature_limit}} K",
        ),
    ]
