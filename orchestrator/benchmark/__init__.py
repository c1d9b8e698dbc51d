"""What co-simulation costs, as ratios within one run: against a loop without FMI, other masters, other contact codes.

`measure` says what is measured, `bench` collects it and prints it. Everything absolute in here is a time on one
machine at one moment, given to show what the ratios are made of.
"""
