"""What a study leaves behind."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from rich.table import Table

from amb_cosim.plots.axes import STYLE
from amb_files.atomic import write_atomically


@dataclass(frozen=True)
class Outcome:
    """What a study found: data for JSON, figures by name, and what to print."""

    data: dict[str, Any]
    figures: dict[str, Callable[[], Figure]]
    printed: list[Table | str]

    def write(self, folder: Path, name: str) -> None:
        """Write `NAME.json` and a PNG for each figure to `folder`, each whole or not at all."""
        text = json.dumps(self.data, indent=1, allow_nan=False) + "\n"
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / f"{name}.json", lambda path: path.write_text(text, encoding="utf-8"))
        for title, draw in self.figures.items():
            with mpl.rc_context(STYLE):
                figure = draw()
                FigureCanvasAgg(figure)
                write_atomically(folder / f"{title}.png", partial(figure.savefig, dpi=200))
