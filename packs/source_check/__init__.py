"""Statements of a source, as data, compared with values that this project computes: criteria, verdicts, one page.

statements        the format of a pack's statements.toml, checked on reading
run_quantities    the named quantities of a run; those of a study are in `study_quantities`
quantities        these, and additions of a pack
requests          a quantity with its arguments and unit, evaluated on a run or a study
source_runs       the run of a scenario for statements
sources           runs and studies for statements, each computed once and stored
verdict           whether a value agrees with its statement, by tolerance and reading
evaluation        statements, computed and judged
study_panels      plots of studies as data
page              one HTML page; `table` is the same in Markdown, `texts` are the texts of both
report_command    the command `report`; `robustness_runs` stores which outcomes are robust
"""
