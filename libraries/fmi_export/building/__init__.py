"""Builds FMUs of both flavours, their descriptions and interface pages; FMUs do not contain this package."""
