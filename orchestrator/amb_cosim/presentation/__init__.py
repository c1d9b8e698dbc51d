"""How results are shown and written: text tables, JSON, progress bars and the style of figures."""
