"""Commands of the thesis's studies."""

from __future__ import annotations

import click

from amb_analysis.studies.commands.analysis import CLOSED_BEARINGS, UP_TO_50_HZ, add_study, study
from amb_cosim.commands.cli import main
from amb_cosim.commands.options import FLAVOUR, ROTOR, SPEED, STIFFNESS, UNBALANCE, WithUnit
from source_check.report_command import report

main.add_section("Design and judge", report)
main.former |= {"tables": "study tables"}  # commands that left

MEASURED_AT = "5 Hz,10 Hz,15 Hz,16 Hz,20 Hz,25 Hz,30 Hz,35 Hz,45 Hz"


add_study(
    "tables",
    ROTOR,
    click.option("--up-to", type=SPEED, default="6000 rpm", show_default=True, help="Highest spin speed."),
    click.option("--planes", help="Nodes to keep (1,4,11,13); default: the master planes."),
)
add_study(
    "reduction",
    click.option("--up-to", type=SPEED, default="4775 rpm", show_default=True, help="Highest spin speed."),
    click.option("--unbalance", type=UNBALANCE, default="0.5 g.m", show_default=True, help="Unbalance on D1."),
)
add_study("coupling_error", FLAVOUR)
add_study(
    "contact_laws",
    click.option("--speed", type=WithUnit("0.1 m/s"), default="0.1 m/s", show_default=True, help="Speed of approach."),
    click.option("--restitution", type=float, default=0.7, show_default=True, help="Coefficient of restitution."),
    click.option("--k-c", type=STIFFNESS, default="1e8 N/m", show_default=True, help="Contact stiffness."),
    click.option(
        "--delta-c",
        type=WithUnit("10 um"),
        default="10 um",
        show_default=True,
        help="Penetration at which the contact laws are fully engaged.",
    ),
    click.option("--mass", type=WithUnit("40 kg"), help="Mass; default: the effective mass of MB1's journal."),
)
add_study(
    "synchronous_response",
    ROTOR,
    UP_TO_50_HZ,
    click.option("--at", type=SPEED, default=MEASURED_AT, show_default=True, help="Speeds of the identifications."),
    *CLOSED_BEARINGS,
    FLAVOUR,
    shows_progress=True,
)
add_study("test_force", UP_TO_50_HZ)
add_study("h_matrix", ROTOR, UP_TO_50_HZ, *CLOSED_BEARINGS)
add_study(
    "recovery",
    click.option(
        "--steps",
        type=WithUnit("8,12,16 g.m", parts=lambda text: text.split(",")[-1:]),  # the last unit is that of all
        default="12,16,18,20,22,24,28,32,36,40,44,48 g.m",
        show_default=True,
        help="Unbalances added on D1; fig5_6 multiplies them by a factor.",
    ),
    click.option(
        "--instants", type=int, default=5, show_default=True, help="Number of instants of the step within a revolution."
    ),
    click.option("--alpha", default="3.5,7 1/s", show_default=True, help="Adaptation rates."),
    FLAVOUR,
    shows_progress=True,
)
main.add_examples({"report": ("report --pack bath_thesis", "report --only fig4_9 -o results/fig4_9_report")})
study.add_examples(
    {
        "tables": ("study tables", "study tables --planes 1,4,11,13"),
        "reduction": ("study reduction", "study reduction --unbalance '1 g.m'"),
        "coupling_error": ("study coupling_error", "study coupling_error --flavour python"),
        "contact_laws": ("study contact_laws", "study contact_laws --speed '0.2 m/s' --restitution 0.5"),
        "synchronous_response": ("study synchronous_response", "study synchronous_response --at '10 Hz,16 Hz'"),
        "test_force": ("study test_force", "study test_force --up-to '35 Hz'"),
        "h_matrix": ("study h_matrix", "study h_matrix --up-to '35 Hz'"),
        "recovery": ("study recovery", "study recovery --steps '12,24 g.m' --instants 2"),
    }
)
