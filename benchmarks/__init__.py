"""What co-simulation costs, as ratios within one run: against a loop without FMI, other masters, other contact codes.

`cases` says what is run, `contestants` by whom and what is inside a timing, `measure` collects it, `report` prints it.
Absolute times hold on one machine at one moment; they show what the ratios are made of.
"""
