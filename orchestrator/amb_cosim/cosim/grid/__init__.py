"""When does a run have values, and which inputs has it then? Communication points, and inputs over time."""
