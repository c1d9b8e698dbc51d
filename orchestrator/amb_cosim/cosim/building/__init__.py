"""Building of FMUs and of the compiled loop: the targets of builds, and the cache."""
