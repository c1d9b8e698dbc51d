"""Selects the copy of the model code that an FMU runs; this file is at the top of the FMU's resources.

All pythonfmu FMUs of a process share one `sys.modules`. If the FMU was built from exactly the code of an installed
package, that package is used, because its compiled kernels are cached on disk. Otherwise, the copy in the FMU is used.
If the process already runs another version of the code, the FMU is refused, because it would silently run that version.
"""

import hashlib
import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

BUILD_ONLY = "building"  # the subpackage that builds FMUs, which neither FMUs nor digests include


def digest(package: Path) -> str:
    """Return a hash of the Python sources of a package folder."""
    sha = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        path = file.relative_to(package)
        if path.parts[0] == BUILD_ONLY:
            continue
        sha.update(path.as_posix().encode(errors="surrogateescape") + b"\0")
        sha.update(file.read_bytes() + b"\0")
    return sha.hexdigest()


def find(name: str) -> Path | None:
    """Return the folder of a loaded or installed package, or None if there is no such package."""
    spec = sys.modules[name].__spec__ if name in sys.modules else importlib.util.find_spec(name)
    return Path(spec.origin).parent if spec is not None and spec.origin else None


# pythonfmu 0.7 runs the script once more for every instance and then releases the script's globals without
# having taken a reference. A reference for each run keeps the module alive however often that happens.
_script_globals: list[dict[str, Any]] = []

# Digest of each package that this process runs. Its folder cannot be read later: hosts delete an extracted
# FMU after use, and its packages stay loaded.
_running: dict[str, str] = {}


def choose_code(script: dict[str, Any]) -> None:
    """Make the packages of an FMU importable; its script calls this first, with its `globals()`.

    Packages that are already loaded remain loaded. `refuse_other_code` later checks whether the FMU was built from the
    loaded packages. The check is not made here, because pythonfmu drops the text of errors that this function raises.
    """
    _script_globals.append(script)
    # pythonfmu puts the resources first; `__file__` would name the folder of the first FMU of this kind.
    resources = Path(sys.path[0])
    sys.path[:] = list(dict.fromkeys(sys.path))  # it adds an entry per instance
    for name, expected in build_facts(resources)["packages"].items():
        folder = find(name)
        installed = digest(folder) if folder is not None else ""
        if name in sys.modules:
            if _running.setdefault(name, installed) == expected:
                _find_also_in(resources / "code", name)
            continue
        _running[name] = expected
        code = str(resources / "code")
        if installed != expected and code not in sys.path:
            sys.path.insert(1, code)
            importlib.invalidate_caches()


def _find_also_in(code: Path, package: str) -> None:
    """Let a loaded package find modules in `code`, because the host may delete the FMU from which it was loaded."""
    for name, module in list(sys.modules.items()):
        if f"{name}.".startswith(f"{package}.") and hasattr(module, "__path__"):
            folders = dict.fromkeys([*module.__path__, str(code.joinpath(*name.split(".")))])
            module.__path__ = [folder for folder in folders if Path(folder).is_dir()]


def refuse_other_code(built: dict[str, Any]) -> None:
    """Check that the process runs the code from which the FMU with these build facts was built.

    Raises
    ------
    ImportError
        If the process runs another version of a package.
    """
    for name, expected in built["packages"].items():
        if _running.get(name) != expected:
            raise ImportError(
                f"this process already runs another version of {name} (from {find(name)}), not the one from which "
                f"{built['model']}.fmu was built; rebuild the FMU or run it in its own process"
            )


def build_facts(resources: Path) -> dict[str, Any]:
    """Return the build facts from an FMU's resources, such as the guid, the version and the digest of each package."""
    facts: dict[str, Any] = json.loads((resources / "build.json").read_text(encoding="utf-8"))
    return facts
