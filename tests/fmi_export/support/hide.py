"""Hides installed packages from a process, so that they are imported only from later entries of `sys.path`."""

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType


def hide(*names: str) -> None:
    """Packages called `names` are no longer found on the present `sys.path`."""
    assert not set(names) & set(sys.modules), "loaded already"
    searched = list(sys.path)

    class Finder:
        invalidate_caches = PathFinder.invalidate_caches
        find_distributions = PathFinder.find_distributions

        @staticmethod
        def find_spec(
            name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
        ) -> ModuleSpec | None:
            if path is None and name in names:
                path = [entry for entry in sys.path if entry not in searched]
            return PathFinder.find_spec(name, path, target)

    sys.meta_path[sys.meta_path.index(PathFinder)] = Finder  # type: ignore[call-overload]
