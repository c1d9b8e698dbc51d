"""The report: every table, figure and number of the thesis's chapters 2 to 6 beside what this project computes.

sources           runs and studies that statements are computed from, each done once and kept
study_quantities  the named quantities of a study; those of a run are in `amb_cosim.thesis`
evaluation        statements, computed and judged
panels            plots as data
page              one HTML page; `table` is the same as Markdown
"""
