"""What a run leaves behind: its result, and the quantities, summary and figures that are made of its signals alone."""
