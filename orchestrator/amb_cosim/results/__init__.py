"""Results of a run: quantities, summary and figures, computed from its signals."""
