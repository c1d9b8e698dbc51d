"""Figures of the studies; the module `figures.NAME` draws the result of the study NAME."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from amb_files.atomic import plain_file, write_file
from amb_files.checks import as_path, require_kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from amb_analysis.studies.result import DrawnResult


def figure(result: DrawnResult) -> Figure:
    """Return a new figure of a study's result; a notebook displays the figure.

    Examples
    --------
    >>> from amb_analysis import studies
    >>> len(figure(studies.campbell("compressor", count=2)).axes)
    2
    """
    import matplotlib as mpl

    from amb_analysis.studies.result import DrawnResult
    from amb_cosim.presentation.style import STYLE

    require_kind("result", result, DrawnResult, "the result of a study")

    with mpl.rc_context(STYLE):
        package = type(result).__module__.rpartition(".")[0]
        drawn: Figure = import_module(f"{package}.figures.{result.name}").draw(result)
    return drawn


def save(result: DrawnResult, folder: Path | str) -> Path:
    """Write the data of a study's result as `NAME.json` and its figure as `NAME.png`, and return the folder.

    The folder is created if it is missing. A file is written completely or not at all.

    Raises
    ------
    OSError
        If the folder or a file cannot be written.

    Examples
    --------
    >>> from amb_analysis import studies
    >>> folder = save(studies.campbell("compressor", count=2), "campbell")
    >>> sorted(file.name for file in folder.iterdir())
    ['campbell.json', 'campbell.png']
    """
    from amb_analysis.studies.result import DrawnResult
    from amb_cosim.presentation.style import write_png

    require_kind("result", result, DrawnResult, "the result of a study")
    texts, folder = result.data_files(), as_path("folder", folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_file(plain_file(folder, name), text)
    write_png(figure(result), plain_file(folder, f"{result.name}.png"))
    return folder
