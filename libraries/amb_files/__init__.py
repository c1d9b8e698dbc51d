"""Handles user files: checks TOML against a declared form, and writes files and folders atomically."""
