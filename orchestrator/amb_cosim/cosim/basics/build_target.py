"""What FMUs are built for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.basics.choices import Flavour, Fmi

if TYPE_CHECKING:
    from fmi_export.model import Model

Constants = NDArray[np.float64]


@dataclass(frozen=True)
class BuildTarget:
    """What an FMU is built for: its flavour, what it runs on (this machine without platforms), the version of FMI,
    whether an FMU of 3.0 has arrays, and whether it holds its C code; see `build_native_fmu` and `build_python_fmu`.

    Raises
    ------
    ValueError
        If these do not go together.
    """

    flavour: Flavour = "native"
    platforms: Iterable[str] | None = None
    fmi: Fmi = 2
    arrays: bool = True
    sources: bool = False

    def __post_init__(self) -> None:
        if self.platforms is not None:  # of each of several FMUs
            object.__setattr__(self, "platforms", tuple(self.platforms))
        if self.fmi == 2 and not self.arrays:
            raise ValueError("FMUs without arrays are of FMI 3.0 (--fmi 3); FMI 2.0 has no arrays")
        if self.flavour == "python" and self.fmi != 2:
            raise ValueError("FMI 3.0 is for native FMUs alone; PythonFMU writes those of flavour python for FMI 2.0")
        if self.flavour == "python" and self.sources:
            raise ValueError(
                "C code is of native FMUs alone (--sources); those of flavour python hold their Python code"
            )

    def build(self, model: Model, constants: Constants, folder: Path) -> Path:
        """Write the FMU of a model with its constants into `folder` and return its path."""
        if self.flavour == "python":
            from fmi_export.building.python_fmu import build_python_fmu

            return build_python_fmu(model, constants, folder, self.platforms)
        from fmi_export.building.native.package import build_native_fmu

        return build_native_fmu(model, constants, folder, self.platforms, self.fmi, self.arrays, self.sources)

    def guid(self, model: Model, constants: Constants) -> str:
        """Return the identifier of that FMU, which changes with all that it is made from."""
        if self.flavour == "python":
            from fmi_export.building.python_fmu import python_guid

            return python_guid(model, constants)
        from fmi_export.building.native.package import native_guid

        return native_guid(model, constants, self.fmi)
