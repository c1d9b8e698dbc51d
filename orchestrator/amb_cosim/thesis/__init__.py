"""What the thesis states in its chapters 2 to 6, as data, and how far a result is from it.

statements.toml   what the thesis states, and how the same is computed here
statements        the form of that file, checked when it is read
run_quantities    the named quantities of a run
asked             a quantity with its arguments and unit, worked out on a run or a study
source_runs       the run of a scenario that statements are computed from
verdict           whether a value is what is stated, by tolerance and reading
misfit            how far a value is from what is stated
"""
