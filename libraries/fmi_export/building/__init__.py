"""Builds FMUs of both flavours, their descriptions and the pages of their interfaces; no FMU contains this package."""
