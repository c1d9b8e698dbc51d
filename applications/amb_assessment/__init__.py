"""Assessment of a machine against standards, the page with its verdicts, and first designs."""
