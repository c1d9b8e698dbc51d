"""The assembled rotor as a native FMU, built once for each scenario."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fmi_export.model import Model


@pytest.fixture(scope="session")
def assembled(create_once: Callable[..., Path]) -> Callable[..., Path]:
    """`assembled(scenario=None)`: path of the FMU; skips the test where it cannot be compiled."""
    pytest.importorskip("numba")
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")

    def build(scenario: str | Path | None = None) -> Path:
        from amb_cosim import build_assembled

        name = "levitated" if scenario is None else Path(scenario).stem
        home = create_once(f"assembled-{name}", lambda folder: build_assembled(folder, scenario))
        return home / "levitated_rotor.fmu"

    return build


@pytest.fixture(scope="session")
def extracted(assembled: Callable[..., Path], unpack: Callable[[Path], Path]) -> Callable[..., Path]:
    """The same argument; folder of the extracted FMU."""
    return lambda *scenario: unpack(assembled(*scenario))


@pytest.fixture(scope="session")
def native_lag(create_once: Callable[..., Path], lag: Model) -> Path:
    """A native FMU of a first-order lag, for comparison."""
    import numpy as np

    from fmi_export.building.native.package import build_native_fmu

    return create_once("native-lag", lambda folder: build_native_fmu(lag, np.zeros(1), folder)) / f"{lag.name}.fmu"
