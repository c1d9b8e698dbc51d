"""Where do compiled FMUs and the compiled loop come from? Targets of builds, and the cache."""
