"""Joins JavaScript modules into one script, so that the page is self-contained and its build needs no other program.

Each module becomes a function that is called once and returns the module's exports, from which imports take names. The
modules use a simple subset of the language. Every import lists names from a file, given by its relative path. Every
export precedes a function, class or constant, or lists names. There are no circular imports.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping
from dataclasses import dataclass

IMPORT = re.compile(r'^import\s*\{([^}]*)\}\s*from\s*"(\.[^"]+)";[ \t]*$', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async )?(?:function\*?|class|const) ([A-Za-z_$][\w$]*))", re.MULTILINE)
LISTED = re.compile(r"^export \{([\w$,\s]*)\};[ \t]*$", re.MULTILINE)
LEFT_OVER = re.compile(r"^(?:import|export)\b.*$", re.MULTILINE)


@dataclass(frozen=True)
class Module:
    """A module: its text without imports and exports, its imports by path and name, and its exports."""

    text: str
    imports: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    exports: tuple[str, ...]


def joined(entry: str, sources: Mapping[str, str]) -> str:
    """Return one script equivalent to a module.

    Parameters
    ----------
    entry
        Path of the module.
    sources
        Texts of modules by path, with `/` between folders.

    Raises
    ------
    ValueError
        If a module is missing, if imports are circular, or if an import or export has an unsupported form.
    """
    order: list[str] = []
    modules: dict[str, Module] = {}

    def visit(path: str, importers: tuple[str, ...]) -> None:
        if path in importers:
            raise ValueError(f"modules import each other in a circle: {' -> '.join((*importers, path))}")
        if path in modules:
            return
        if path not in sources:
            raise ValueError(f"{importers[-1] if importers else 'the page'} imports {path}, which does not exist")
        module = read_module(path, sources[path])
        for imported, _ in module.imports:
            visit(imported, (*importers, path))
        modules[path] = module
        order.append(path)

    visit(entry, ())
    number = {path: k for k, path in enumerate(order)}
    parts = [_wrapped(path, modules[path], number) for path in order]
    return '"use strict";\n' + "".join(parts)


def read_module(path: str, source: str) -> Module:
    """Return a module from its text.

    Raises
    ------
    ValueError
        If an import or export has an unsupported form.
    """
    imports = tuple(
        (posixpath.normpath(posixpath.join(posixpath.dirname(path), place)), _names(names))
        for names, place in IMPORT.findall(source)
    )
    text = IMPORT.sub("", source)
    listed = [name.strip() for names in LISTED.findall(text) for name in names.split(",") if name.strip()]
    exports = (*EXPORT.findall(text), *listed)
    text = EXPORT.sub("", LISTED.sub("", text))
    unsupported = LEFT_OVER.search(text)
    if unsupported is not None:
        raise ValueError(
            f"{path}: {unsupported.group()!r} is not allowed; it must be an import of names from a relative "
            "path, an export of names, or an export of a function, class or const"
        )
    return Module(text.strip() + "\n", imports, exports)


def _names(names: str) -> tuple[tuple[str, str], ...]:
    """Return the names of an import, both in the other module and in this one."""
    pairs = [name.split(" as ") for name in names.replace("\n", " ").split(",") if name.strip()]
    return tuple((pair[0].strip(), pair[-1].strip()) for pair in pairs)


def _wrapped(path: str, module: Module, number: Mapping[str, int]) -> str:
    imports = "".join(
        f"const {{ {', '.join(a if a == b else f'{a}: {b}' for a, b in names)} }} = module{number[place]};\n"
        for place, names in module.imports
    )
    values = f"return {{ {', '.join(module.exports)} }};\n"
    return f"// {path}\nconst module{number[path]} = (() => {{\n{imports}{module.text}{values}}})();\n"
