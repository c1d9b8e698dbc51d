"""Measure the cost of co-simulation, as ratios to a loop without FMI, other masters and other contact codes.

All ratios are measured in one run, because absolute times depend on the machine and its load. `cases` defines the runs,
`candidates` the programs that are timed; `measure` collects the times, `report` prints them.
"""
