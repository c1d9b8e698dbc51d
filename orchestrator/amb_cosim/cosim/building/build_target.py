"""Targets of FMU builds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from amb_cosim.cosim.choices import FLAVOURS, FMIS, Flavour, Fmi
from amb_files.archive import write_archive
from amb_files.checks import as_names, require_choice
from array_types import Array

if TYPE_CHECKING:
    from fmi_export.model import Model


@dataclass(frozen=True)
class BuildTarget:
    """Target of an FMU build: flavour, platforms (by default this machine), FMI version, arrays, included C code.

    Raises
    ------
    ValueError
        If a setting is not allowed, or the settings are incompatible.
    """

    flavour: Flavour = "native"
    platforms: str | Iterable[str] | None = None
    fmi: Fmi = 2
    arrays: bool = True
    sources: bool = False

    def __post_init__(self) -> None:
        require_choice("flavour", self.flavour, FLAVOURS)
        require_choice("fmi", self.fmi, FMIS)
        if self.platforms is not None:  # an iterator would serve only the first of several FMUs
            object.__setattr__(self, "platforms", as_names("platforms", self.platforms))
        if self.fmi == 2 and not self.arrays:
            raise ValueError("FMUs without arrays require FMI 3.0 (fmi = 3); FMI 2.0 never has arrays")
        if self.flavour == "python" and self.fmi != 2:
            raise ValueError("FMI 3.0 requires native FMUs; PythonFMU supports only FMI 2.0")
        if self.flavour == "python" and self.sources:
            raise ValueError("sources = True is not allowed with flavour = python; such FMUs contain their Python code")

    def fmu(self, model: Model, constants: Array) -> bytes:
        """Return the FMU of a model with its constants."""
        if self.flavour == "python":
            from fmi_export.building.python_fmu import python_fmu

            return python_fmu(model, constants, self.platforms)
        from fmi_export.building.native.package import native_fmu

        return native_fmu(model, constants, self.platforms, self.fmi, self.arrays, self.sources)

    def build(self, model: Model, constants: Array, folder: Path) -> Path:
        """Write the FMU of a model with its constants into `folder` and return its path."""
        fmu = self.fmu(model, constants)
        folder.mkdir(parents=True, exist_ok=True)
        return write_archive(folder / f"{model.name}.fmu", fmu)

    def guid(self, model: Model, constants: Array) -> str:
        """Return the identifier of this FMU, which depends on everything that it is made from."""
        if self.flavour == "python":
            from fmi_export.building.python_fmu import python_guid

            return python_guid(model, constants)
        from fmi_export.building.native.package import native_guid

        return native_guid(model, constants, self.fmi)
