"""Pages and pictures of verdicts: plots as data, short texts, styles and scripts of the page."""
