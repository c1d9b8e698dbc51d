"""Presentation of results: text tables, JSON, progress bars and the style of figures."""
