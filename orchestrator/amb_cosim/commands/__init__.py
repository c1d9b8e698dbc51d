"""The commands of `amb-cosim`, one file per group."""
