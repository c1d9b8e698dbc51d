"""The commands `study`, `linearise`, `identify`, and `rotor show`."""

from amb_cosim.commands.cli import main
from amb_cosim.studies.commands import rotor as rotor
from amb_cosim.studies.commands.analysis import linearise, study
from amb_cosim.studies.commands.identify import identify

main.add_section("Design and judge", study, identify, linearise)
