"""Files that a user writes or keeps: TOML checked against a declared form, files and folders that appear whole."""
