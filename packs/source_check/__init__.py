"""Comparison of a source's statements, given as data, with values that this project computes.

statements        the format of a pack's statements.toml, which is checked when it is read
run_quantities    the named quantities of a run; `study_quantities` has the quantities of a study
quantities        all of these quantities, and those that a pack adds
requests          a quantity with its arguments and unit, which is evaluated for a run or a study
source_runs       the run of a scenario for statements
sources           runs and studies for statements, each of which is computed once and stored
verdict           whether a value agrees with its statement, by tolerance and reading
evaluation        computation and judgement of statements
study_panels      plots of studies as data
page              the HTML page; `table` is the same in Markdown, and `texts` has the texts of both
report_command    the command `report`; `robustness_runs` stores which outcomes are robust
"""
