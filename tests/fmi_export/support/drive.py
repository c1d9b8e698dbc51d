"""Drives one FMU through fmpy by variable names; for use in a subprocess."""

from contextlib import suppress
from pathlib import Path

import fmpy
from fmpy.fmi1 import FMICallException


class Fmu:
    """An instance of an extracted or packed FMU, with its log as a list of sentences."""

    def __init__(self, path: str, initialise: bool = True, **values: float) -> None:
        self.log: list[str] = []
        self.folder = path if Path(path).is_dir() else fmpy.extract(path)
        self.description = fmpy.read_model_description(self.folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmi = fmpy.instantiate_fmu(
            self.folder,
            self.description,
            "CoSimulation",
            debug_logging=True,
            logger=lambda environment, name, status, category, message: self.log.append(message.decode()),
        )
        self.set(**values)
        self.fmi.setupExperiment(startTime=0.0)
        self.fmi.enterInitializationMode()
        if initialise:
            self.fmi.exitInitializationMode()

    def set(self, **values: float) -> None:
        """Values by name, with `__` for the dot."""
        for name, value in values.items():
            v = self.variables[name.replace("__", ".")]
            set_ = {"Real": self.fmi.setReal, "Boolean": self.fmi.setBoolean}.get(v.type, self.fmi.setInteger)
            set_([v.valueReference], [value if v.type == "Real" else int(value)])

    def get(self, *names: str) -> list[float]:
        get = {"Real": self.fmi.getReal, "Boolean": self.fmi.getBoolean}
        chosen = (
            (self.variables[n].valueReference, get.get(self.variables[n].type, self.fmi.getInteger)) for n in names
        )
        return [function([reference])[0] for reference, function in chosen]

    def outputs(self) -> list[float]:
        return self.get(*(n for n, v in self.variables.items() if v.causality == "output"))

    def step(self, n: int, step_size: float = 250e-6) -> int:
        """Do step number `n`; the FMI status."""
        try:
            self.fmi.doStep(n * step_size, step_size)
        except FMICallException as error:
            return error.status
        return 0

    def close(self) -> None:
        with suppress(FMICallException):  # after a fault
            self.fmi.terminate()
        self.fmi.freeInstance()
