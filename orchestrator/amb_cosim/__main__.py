"""The command line, as `python -m amb_cosim`."""

from amb_cosim.start import main

main()
