"""Loads modules from a changed source, which can call `switch_is_on` of `switch`."""

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
    """Loads modules whose file `is_changed` as `changed(file)` returns them; create it before they are imported."""

    def __init__(self, is_changed: Callable[[Path], bool], changed: Callable[[Path], ast.Module]) -> None:
        self.is_changed, self.changed = is_changed, changed
        with suppress(ImportError):
            import numba

            self.kernels = tempfile.TemporaryDirectory()  # kernels compiled from changed sources must not be reused
            vars(numba.config)["CACHE_DIR"] = self.kernels.name
        sys.meta_path.insert(0, self)

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if "." not in name or spec is None or spec.origin is None or not self.is_changed(Path(spec.origin)):
            return None
        return importlib.machinery.ModuleSpec(name, self, origin=spec.origin)

    def exec_module(self, module: Any) -> None:
        from tools.instruments.switch import switch_is_on

        file = module.__spec__.origin
        module.__dict__.update(switch_is_on=switch_is_on, __file__=file)
        exec(compile(self.changed(Path(file)), file, "exec"), module.__dict__)
