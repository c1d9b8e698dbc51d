"""Co-simulation of FMI 2.0 and 3.0 FMUs: components, systems, master, recording. Nothing here is specific to rotors.

system          System, Component, Connection, Signal: what is connected with what, checked
system_file     a system, and an experiment with it, from a TOML file
fmus            FMUs of models and files, built for a build_target into the cache; fmu_libraries: checks
experiment      Experiment: times, events, profiles, stop conditions, recording, in seconds; planning: on the time_grid
assignments     values of parameters and inputs, with units
assembly        assemble: a system with its FMUs
execution       execute_plan: from a plan, which has its assembly, to a recording; simulator: what it runs
simulate        simulate a system file: all of the above in a single call
master          the algorithm, in plain Python; compiled: the same in C, by loop.c of fmi_export and loop_library
component       an FMU instance; bindings: the functions of FMI 2.0 (binding2) and 3.0 (binding3); exchange: values
fmu_interface   what a modelDescription says; fmu_description reads it
recorder        what is stored; dataset: the same with labels and units, as signals; netcdf: their file
choices         what a user chooses between; errors: of FMUs and runs; interruption: Ctrl-C and SIGTERM
"""
