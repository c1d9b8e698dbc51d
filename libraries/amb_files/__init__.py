"""User files: TOML checked against a declared form, files and folders written atomically."""
