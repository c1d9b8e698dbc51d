"""The live rig: a scenario, its FMUs as WebAssembly, and the page that runs them in a browser.

The package can be called like a function: the line `amb_cosim.live("my_scenario.toml")` at the end of a cell opens the
page in a notebook; see `amb_live.notebook.live`.
"""

from __future__ import annotations

import sys
from types import ModuleType

TYPE_CHECKING = False  # as in `typing`, which takes longer to import than this

if TYPE_CHECKING:
    from typing import Any

    from amb_live.notebook import LivePage


class _CallableModule(ModuleType):
    """A package that can be called like its function `notebook.live`."""

    def __call__(self, *arguments: Any, **options: Any) -> LivePage:
        """Create the page of a scenario; see `amb_live.notebook.live`."""
        from amb_live.notebook import live

        return live(*arguments, **options)


sys.modules[__name__].__class__ = _CallableModule
