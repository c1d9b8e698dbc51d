"""The commands of `amb-cosim`, one file for each group of them."""
