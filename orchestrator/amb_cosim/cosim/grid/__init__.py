"""When does a run have values, and which inputs does it have then? Communication points, and inputs over time."""
