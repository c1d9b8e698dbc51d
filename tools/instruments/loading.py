"""Modules that are loaded from a changed source, in which `switch_is_on` of `switch` is known."""

from __future__ import annotations

import ast
import importlib.abc
import importlib.machinery
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any


class ChangedSources(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads modules whose file is wanted as `changed(file)` returns them; must begin before anything imports them."""

    def __init__(self, is_wanted: Callable[[Path], bool], changed: Callable[[Path], ast.Module]) -> None:
        self.is_wanted, self.changed = is_wanted, changed
        with suppress(ImportError):
            import numba

            self.kernels = tempfile.TemporaryDirectory()  # what is compiled here is of no use to others
            vars(numba.config)["CACHE_DIR"] = self.kernels.name
        sys.meta_path.insert(0, self)

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if "." not in name or spec is None or spec.origin is None or not self.is_wanted(Path(spec.origin)):
            return None
        return importlib.machinery.ModuleSpec(name, self, origin=spec.origin)

    def exec_module(self, module: Any) -> None:
        from tools.instruments.switch import switch_is_on

        file = module.__spec__.origin
        module.__dict__.update(switch_is_on=switch_is_on, __file__=file)
        exec(compile(self.changed(Path(file)), file, "exec"), module.__dict__)
