"""The commands `study`, `linearise`, `identify`, `rotor show` and `controller show`."""

from amb_analysis.studies.commands import controller as controller
from amb_analysis.studies.commands import rotor as rotor
from amb_analysis.studies.commands.analysis import linearise, study
from amb_analysis.studies.commands.identify import identify
from amb_cosim.commands.cli import main

main.add_section("Design and judge", study, identify, linearise)
main.add_examples(
    {
        "study": ("study campbell --rotor compressor", "study poles compressor_levitated"),
        "identify": (
            "identify -o table.toml",
            "identify --scenario pump/levitation.toml --computed",
        ),
        "linearise": ("linearise compressor_levitated -o loop.mat", "linearise drop --component rotor_contact"),
        "rotor show": ("rotor show compressor", "rotor show pump/rotor.toml -o pump.png"),
        "controller show": (
            "controller show pump/controller.toml",
            "controller show lead.toml --rotor compressor -o bode.png",
        ),
    }
)
