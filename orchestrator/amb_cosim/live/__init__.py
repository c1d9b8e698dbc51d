"""The live rig: a page on which a browser runs the machine code of the FMUs."""
