"""The report: every table, figure and number of the thesis's chapters 2 to 6 beside what this project computes.

statements.toml   what the thesis states, and how the same is computed here
statements        the form of that file, checked when it is read
sources           runs and studies that statements are computed from, each done once and kept
run_quantities, study_quantities    the named quantities of a run and of a study
verdict           a verdict from value, tolerance and reading
evaluation        all of it together: statements, computed and judged
panels            plots as data
page              one HTML page; `table` is the same as Markdown
"""
