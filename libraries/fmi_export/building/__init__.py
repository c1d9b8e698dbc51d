"""Builds FMUs of both flavours, their descriptions and the tables of their READMEs; no FMU contains this package."""
