"""The live rig within a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path

from amb_files.atomic import write_file

HEIGHT = 900  # pixels


@dataclass(frozen=True, repr=False)
class LivePage:
    """A page of the live rig, which a notebook shows in a frame.

    scenario
        Name of the first scenario.
    text
        The page, which requires no other file and no server.
    height
        Height of the frame (pixels).
    """

    scenario: str
    text: str
    height: int = HEIGHT

    def save(self, path: str | Path) -> Path:
        """Write the page to a file for a browser, atomically."""
        file = Path(path)
        write_file(file, self.text)
        return file

    def __repr__(self) -> str:
        return f"<live rig of {self.scenario}, {len(self.text) / 1e6:.1f} MB; save(path) writes it>"

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {self.height}px; border: 0"
        page = escape(self.text, quote=True)
        return f'<iframe title="Live rig: {escape(self.scenario)}" style="{style}" srcdoc="{page}"></iframe>'


def live(
    scenario: str | Path | None = None, *, rotor: str | Path | None = None, others: bool = False, height: int = HEIGHT
) -> LivePage:
    """Return the page that runs a scenario in a browser; a notebook shows it.

    Parameters
    ----------
    scenario
        Name of a packaged scenario, or scenario file; default: the packs' default scenario.
    rotor
        Rotor that replaces the scenario's.
    others
        Whether the page includes the scenarios of the packs.
    height
        Height of the frame in a notebook (pixels), 200 or more.

    Raises
    ------
    ValueError
        If the scenario, the rotor or a file is invalid, if a browser cannot run the scenario, or if the height is below
        200.
    """
    from amb_live.choice import rigs_of
    from amb_live.page import page

    if height < 200:
        raise ValueError(f"height = {height} px is not allowed; it must be 200 px or more")
    name, rotor_name = (None if source is None else str(source) for source in (scenario, rotor))
    rigs = rigs_of(name, rotor_name, alone=not others)
    return LivePage(rigs[0].data["scenario"], page(rigs), height)
