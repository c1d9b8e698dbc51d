<<<<<<< HEAD
"""The live rig: a page on which a browser runs the machine code of the FMUs."""
=======
"""The live rig: a scenario, its FMUs as WebAssembly, and the page that runs them in a browser."""
>>>>>>> bcd2286a7277f4d1bb3615feb1280f140a1c7173
