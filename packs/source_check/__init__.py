"""What a source states, as data, beside what this project computes: criteria, verdicts, one page.

statements        the form of a pack's statements.toml, checked when it is read
run_quantities    the named quantities of a run; those of a study are in `study_quantities`
quantities        these, and what a pack adds
requests          a quantity with its arguments and unit, evaluated on a run or a study
source_runs       the run of a scenario that statements are computed from
sources           runs and studies that statements are computed from, each done once and kept
verdict           whether a value is what is stated, by tolerance and reading
evaluation        statements, computed and judged
study_panels      plots of studies as data
page              one HTML page; `table` is the same as Markdown, `texts` are the words of both
report_command    the command `report`; `robustness_command` has the command `robustness`
"""
