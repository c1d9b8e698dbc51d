"""How are the verdicts shown? The HTML page, its PDF, and the description that `--check` prints."""
