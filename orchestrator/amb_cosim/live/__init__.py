"""The live rig: a scenario, its FMUs as WebAssembly, and the page that runs them in a browser."""
