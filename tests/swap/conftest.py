"""FMUs that replace the components of the rig, built once."""

from collections.abc import Callable
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parent / "support"


@pytest.fixture(scope="session")
def python_fmus(create_once: Callable[..., Path]) -> Path:
    """Folder of the FMUs of PythonFMU."""
    from pythonfmu.builder import FmuBuilder

    def fill(folder: Path) -> None:
        for name in ("linear_actuator", "full_rotor"):
            FmuBuilder.build_FMU(SUPPORT / f"{name}.py", dest=folder)

    return create_once("python_fmus", fill)


@pytest.fixture(scope="session")
def c_controller(fmu_from_c: Callable[..., Path]) -> Path:
    """The controller in C."""
    return fmu_from_c(SUPPORT / "pd_controller.c", (SUPPORT / "pd_controller.xml").read_text(encoding="utf-8"))
