"""Four displacement sensors with a lag."""
