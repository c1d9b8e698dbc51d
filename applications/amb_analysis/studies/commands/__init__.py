"""The commands `study`, `linearise`, `identify`, `rotor show` and `controller show`."""

from amb_analysis.studies.commands import controller as controller
from amb_analysis.studies.commands import rotor as rotor
from amb_analysis.studies.commands.analysis import linearise, study
from amb_analysis.studies.commands.identify import identify
from amb_cosim.commands.cli import main

main.add_section("Design and judge", study, identify, linearise)
