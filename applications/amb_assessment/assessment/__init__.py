"""Assessment of a machine file against criteria from files, on one page.

format     machine files, criteria files, and the quantities that criteria limit
physics    the machine that a file describes, its runs and its stability
analyses   parts of an assessment, each a module
engine     runs all analyses in sequence and judges what they compute; a failed analysis does not stop the others
page       an HTML page, which is also printed as PDF
"""
