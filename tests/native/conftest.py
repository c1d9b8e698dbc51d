"""Native FMUs and hosts, built once; tests that need the C compiler are skipped where it is not installed."""

import hashlib
import importlib
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import run_program

from fmi_export.building.native.data import model_data
from fmi_export.building.native.engines import engine_key, engine_sources
from fmi_export.building.native.package import Fmi, build_native_fmu, native_guid
from fmi_export.building.native.sources import FOLDER
from fmi_export.model import Model

HEADERS = FOLDER / "fmi_headers"


@pytest.fixture(scope="session")
def matrix() -> Model:
    """A matrix times a vector, whose variables are arrays in FMI 3.0 (`support/probe_matrix`)."""
    return importlib.import_module("probe_matrix.model").MODEL


@pytest.fixture(scope="session")
def plant() -> Model:
    from amb_cosim.model_constants.plant_data import plant

    return plant()[0]


@pytest.fixture(scope="session")
def plant_constants() -> Any:
    from amb_cosim.model_constants.plant_data import plant

    return plant()[1]


@pytest.fixture(scope="session")
def compiler() -> None:
    """Skip tests that need `ziglang`."""
    pytest.importorskip("numba")
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


@pytest.fixture(scope="session")
def native(compiler: None, create_once: Callable[..., Path]) -> Callable[..., Path]:
    """`native(model, constants=None, platforms=None, fmi=2)`: path of the FMU, built once per test run."""

    def build(model: Model, constants: Any = None, platforms: Sequence[str] | None = None, fmi: Fmi = 2) -> Path:
        numbers = np.zeros(1) if constants is None else constants
        facts = [native_guid(model, numbers, fmi), model.step.__qualname__, model.initialise.__qualname__, platforms]
        name = f"{model.name}-{hashlib.sha256(repr(facts).encode()).hexdigest()[:32]}"
        home = create_once(name, lambda folder: build_native_fmu(model, numbers, folder, platforms, fmi))
        return home / f"{model.name}.fmu"

    return build


@pytest.fixture(scope="session")
def unpacked(native: Callable[..., Path], unpack: Callable[[Path], Path]) -> Callable[..., Path]:
    """The same arguments as `native`; folder of the extracted FMU."""
    return lambda *arguments: unpack(native(*arguments))


@pytest.fixture(scope="session")
def library_of(
    unpacked: Callable[..., Path], build_fmu: Callable[..., Path], unpack: Callable[[Path], Path], lag: Model
) -> Callable[[str], Any]:
    """`library_of(flavour)`: the library of the lag in one of `FLAVOURS`, as `raw` calls it."""
    from raw import Library, Library3

    def load(flavour: str) -> Any:
        if flavour != "python":
            return Library3(unpacked(lag, None, None, 3)) if flavour == "native 3" else Library(unpacked(lag))
        return Library(unpack(build_fmu(lag)))

    return load


FLAVOURS = ("native", "native 3", "python")  # native with the functions of FMI 2.0, with those of FMI 3.0, and python


@pytest.fixture(scope="module", params=FLAVOURS)
def library(request: pytest.FixtureRequest, library_of: Callable[[str], Any]) -> Any:
    """The lag as each flavour and version of FMI has it."""
    return library_of(request.param)


@pytest.fixture(scope="module", params=["native", "python"])
def library2(request: pytest.FixtureRequest, library_of: Callable[[str], Any]) -> Any:
    """The lag as each flavour has it with FMI 2.0."""
    return library_of(request.param)


@pytest.fixture(scope="session")
def cc(compiler: None) -> Callable[..., None]:
    """`cc(*arguments)`: zig's C compiler."""

    def run(*arguments: Any) -> None:
        run_program(sys.executable, "-m", "ziglang", "cc", *arguments)

    return run


@pytest.fixture(scope="session")
def sanitized(cc: Callable[..., None], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[Any, ...]]:
    """`sanitized(model, constants, compiler="gcc", sanitizer="address,undefined")`: host, library, guid, resources.

    Host and library have a compiler's sanitizers, the kernels are compiled by zig. With libFuzzer the host is a fuzzer.
    """
    support = Path(__file__).parent / "support"

    def build(
        model: Model, constants: Any, compiler: str = "gcc", sanitizer: str = "address,undefined"
    ) -> tuple[Any, ...]:
        if not shutil.which(compiler):
            pytest.skip(f"needs {compiler} with its sanitizers")
        folder = tmp_path_factory.mktemp(f"sanitized-{model.name}")
        for name, text in engine_sources(model.compiled).items():
            (folder / name).write_text(text)
        guid = native_guid(model, constants)
        (folder / "model.bin").write_bytes(model_data(model, constants, guid, engine_key(model.compiled)))
        for kernels in folder.glob("*.ll"):
            cc("-c", "-O2", "-fPIC", "-Wno-override-module", kernels, "-o", kernels.with_suffix(".o"))
        common = ["-std=gnu11", "-g", "-O1", "-fno-sanitize-recover=all"]
        flags = [*common, f"-fsanitize={sanitizer}"]
        of_library = [*common, f"-fsanitize={sanitizer.replace('fuzzer', 'fuzzer-no-link')}"]
        strict = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror"] if compiler == "gcc" else []
        fuzzed = ["-DFUZZED"] if "fuzzer" in sanitizer else []
        links = ["-ldl", "-lpthread"]
        sources = sorted(folder.glob("*.c"))
        commands = [
            [*of_library, *strict, "-shared", "-fPIC", "-o", folder / "fmu.so", *sources, *folder.glob("*.o"), "-lm"],
            [*flags, *fuzzed, f"-I{HEADERS}", "-o", folder / "host", support / "host.c", *links],
        ]
        if not fuzzed:
            commands.append([*flags, f"-I{HEADERS}", "-o", folder / "fuzz3", support / "fuzz3.c", "-ldl"])
        for command in commands:
            run_program(compiler, *command)
        return folder / "host", folder / "fmu.so", guid, folder.as_uri()

    return build
