"""The signal chain of a sampled controller: sensors with faults, filter, converters, sampling instants."""
