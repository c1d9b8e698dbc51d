"""The co-simulation: wiring as data, master algorithm, FMU adapter, scenarios, results, plots, commands."""
