"""The pythonfmu slave of any model: it holds an instance and passes calls on.

The guard before PythonFMU's library lets calls come here in the order of the standard alone, with references that
exist, are of the right type and may be set now, and with states of this FMU that are whole. What is wrong beyond that
is logged as an error, with which the guard answers the call, and stays as `fault_code`. The guard says at what time.

Nothing may leave a slave method as an exception: PythonFMU would corrupt reference counts, and the guard would not call
it any more.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from fmi_export.log_categories import LOG_CATEGORIES
from fmi_export.model import START, Array, Fault, Instance, Model, with_starts

FAULT_INTERNAL = 998
REMEMBERED = 1000  # lists of value references; hosts use the same few in every step


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """Base of the FMUs' entry points; a subclass names its `model`, or makes it from a layout by `model_of`."""

    model: Model
    log_categories = LOG_CATEGORIES

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        import amb_cosim_bootstrap  # lies beside the script that runs this

        resources = Path(self.resources)
        self.build = amb_cosim_bootstrap.build_facts(resources)
        amb_cosim_bootstrap.refuse_other_code(self.build)
        layout = json.loads((resources / "layout.json").read_text(encoding="utf-8"))
        starts = layout.pop(START, {})
        self.model = with_starts(self.model_of(layout), starts)
        self.modelName = self.model.name
        self.guid = self.build["guid"]
        self.instance = Instance(self.model, np.load(resources / "constants.npy"))
        self._known: dict[tuple[int, ...], NDArray[np.intp]] = {}
        self._initialising = True
        self._stale = True

    @classmethod
    def model_of(cls, layout: dict[str, Any]) -> Model:
        """Return the model with the interface that `layout`, see `Model`, says."""
        return cls.model

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        from fmi_export.building.description import model_description  # called by the build alone; an FMU lacks it

        return model_description(self.model, self.guid, self.build["tool"], self.build["version"])

    # Life cycle --------------------------------------------------------------------------------------------

    def setup_experiment(self, start_time: float, *_: Any) -> None:
        self._stale = True

    def enter_initialization_mode(self) -> None:
        self._stale = True

    def exit_initialization_mode(self) -> None:
        self._refresh()
        self._initialising = False
        if self.instance.fault:
            self._say_fault()
        else:
            self._warn()

    def do_step(self, current_time: float, step_size: float) -> bool:
        try:
            self.instance.step(current_time, step_size)
        except Exception as error:
            self._refuse(error)
            return False
        self._warn()
        return True

    def _refresh(self) -> bool:
        """Initialise again if a variable was set, so that outputs are up to date throughout initialisation mode.

        Returns whether that brought a fault, which can still be put right there.
        """
        if not (self._initialising and self._stale):
            return False
        self._stale = False
        try:
            self.instance.initialise()
        except Fault:
            return True
        except Exception as error:
            self.instance.stop(FAULT_INTERNAL, str(error))
            return True
        return False

    def _refuse(self, error: Exception, where: str = "") -> None:
        if not isinstance(error, Fault):
            self.instance.stop(FAULT_INTERNAL, f"{where}{error}")
        self._say_fault()

    def _say_fault(self) -> None:
        self.log(self.instance.message, Fmi2Status.error)

    def _warn(self) -> None:
        """Log each warning when it is true for the first time."""
        for warning in self.instance.new_warnings():
            self.log(warning, Fmi2Status.warning)

    # Variables ---------------------------------------------------------------------------------------------

    def get_real(self, vrs: list[int]) -> list[float]:
        return self._read(vrs).tolist()

    def get_integer(self, vrs: list[int]) -> list[int]:
        try:
            return [int(value) for value in self._read(vrs).tolist()]
        except (ValueError, OverflowError) as error:
            self._refuse(error, f"get {vrs}: ")
            return [0] * len(vrs)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return (self._read(vrs) != 0.0).tolist()

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        try:
            self.instance.values[self._where(vrs)] = values
        except Exception as error:
            self._refuse(error, f"set {vrs}: ")
        self._stale = True

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self.set_real(vrs, values)  # type: ignore[arg-type]

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self.set_real(vrs, values)  # type: ignore[arg-type]

    def _read(self, vrs: list[int]) -> Array:
        try:
            if self._refresh():
                self._say_fault()
            return self.instance.values[self._where(vrs)]
        except Exception as error:
            self._refuse(error, f"get {vrs}: ")
            return np.zeros(len(vrs))

    def _where(self, vrs: list[int]) -> NDArray[np.intp]:
        key = tuple(vrs)
        where = self._known.get(key)
        return _remember(self._known, key, vrs) if where is None else where

    # State -------------------------------------------------------------------------------------------------

    def _get_fmu_state(self) -> dict[str, Any]:
        instance = self.instance
        return {
            "values": instance.values.tobytes(),
            "state": instance.state.tobytes(),
            "fault": instance.fault,
            "message": instance.message,
            "initialising": self._initialising,
            "stale": self._stale,
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        try:
            self.instance.values[:] = np.frombuffer(state["values"])
            self.instance.state[:] = np.frombuffer(state["state"])
            self.instance.fault = state["fault"]
            self.instance.message = state["message"]
            self._initialising = state["initialising"]
            self._stale = state["stale"]
        except Exception as error:
            self._refuse(error, "state: ")

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        text = {k: base64.b64encode(v).decode() if isinstance(v, bytes) else v for k, v in state.items()}
        return json.dumps(text).encode()

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        text: dict[str, Any] = json.loads(state.decode())
        return text | {k: base64.b64decode(text[k]) for k in ("values", "state")}


def _remember(known: dict[tuple[int, ...], NDArray[np.intp]], key: tuple[int, ...], vrs: list[int]) -> NDArray[np.intp]:
    """Return value references as an index, and store it for the next call with them."""
    if len(known) >= REMEMBERED:
        known.clear()
    known[key] = where = np.array(vrs, np.intp)
    return where
