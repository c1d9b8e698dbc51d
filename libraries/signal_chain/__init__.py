"""Around the law of a sampled controller: sensors with their faults, filter, converters, instants of its samples."""
