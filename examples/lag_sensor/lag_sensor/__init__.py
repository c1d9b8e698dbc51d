"""Eight displacement sensors with a lag."""
