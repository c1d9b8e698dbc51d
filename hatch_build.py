"""Compiles the engines of the native FMUs into a wheel.

They are for this machine, or for the platforms that AMB_COSIM_PLATFORMS names, commas between them, or `all`, which
has WebAssembly for browsers too. The wheel's tag says so. An editable installation gets none: its sources may change,
and what is missing is compiled at first use.
"""

from __future__ import annotations

import importlib
import os
import sys
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "AMB_COSIM_PLATFORMS"
TARGET = "fmi_export/building/native/engines"
LOOPS = "amb_cosim/cosim/building/loops"

# What an engine runs on, in the words of Python's packaging.
TAGS = {
    "linux64": "manylinux_2_17_x86_64",
    "win64": "win_amd64",
    "darwin64": "macosx_11_0_universal2",
    "aarch64-linux": "manylinux_2_17_aarch64",
    "aarch64-darwin": "macosx_11_0_arm64",
}


class ModelKernels(NamedTuple):
    """What an engine is compiled from."""

    name: str
    initialise: Any
    step: Any
    packages: tuple[str, ...]

    @classmethod
    def in_module(cls, name: str, module: str) -> ModelKernels:
        code = importlib.import_module(module)
        package = importlib.import_module(module.partition(".")[0])
        return cls(name, code.initialise, code.step, getattr(package, "PACKAGES", (package.__name__, "fmi_export")))


class EngineBuildHook(BuildHookInterface[Any]):
    """Adds the engines of the models that `kernels` names to the wheel, and the one of all in an assembly."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        sys.path[:0] = [str(Path(self.root) / name) for name in ("fmus", "libraries", "orchestrator", "applications")]
        from amb_cosim.cosim.building.loop_library import compile_loop, loop_place
        from fmi_export.building.guard.libraries import SYSTEMS, guard, guard_place
        from fmi_export.building.native.compiler import PLATFORMS, TARGETS, WASM, check_platforms, host_platform
        from fmi_export.building.native.engines import engine, engine_place

        named = os.environ.get(VARIABLE)
        try:
            platforms = check_platforms(named.split(",")) if named else [host_platform()]
        except ValueError as error:
            if named:
                raise SystemExit(f"{VARIABLE} = {named}: {error}") from None
            return  # there is no native FMU for this machine
        machines = [platform for platform in platforms if platform != WASM]
        targets = list(TARGETS) if machines == list(PLATFORMS) else platforms
        models = [ModelKernels.in_module(name, module) for name, module in sorted(self.config["kernels"].items())]
        self._stage = tempfile.TemporaryDirectory(prefix="engines-")

        engines, loops = Path(self._stage.name, "engines"), Path(self._stage.name, "loops")

        def add(together: tuple[ModelKernels, ...]) -> None:
            for platform in targets:
                engine(together, platform).write(engines / engine_place(together, platform))

        for platform in machines:
            if platform in SYSTEMS:
                guard(platform).write(engines / guard_place(platform))
            place = loops / loop_place(platform)
            place.parent.mkdir(parents=True)
            place.write_bytes(compile_loop(platform))
        assembled = tuple(model for model in models if model.name in self.config["assembled"])
        with ThreadPoolExecutor() as pool:  # an engine waits for kernels that another is lowering
            list(pool.map(add, [*((model,) for model in models), assembled]))
        build_data["force_include"][str(engines)] = TARGET
        build_data["force_include"][str(loops)] = LOOPS
        if machines and machines != list(PLATFORMS):
            here = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"] = False
            build_data["tag"] = "py3-none-" + (".".join(TAGS[name] for name in machines) if named else here)

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if stage := getattr(self, "_stage", None):
            stage.cleanup()
