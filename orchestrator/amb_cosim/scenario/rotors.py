"""Rotor, table of receptances and controllers of a scenario: names, files, or objects made in Python."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import SerializerFunctionWrapHandler, TypeAdapter, ValidatorFunctionWrapHandler
from pydantic import WrapSerializer as Serialised
from pydantic import WrapValidator as Checked

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from amb_cosim.controllers.linear_controller import LinearController
    from amb_cosim.model_constants.receptance_file import ReceptanceTable
    from rotor_analysis.rotor import Rotor
    from rotor_analysis.rotor_file import RotorSource as RotorSource

    RotorField = Rotor | str
    TableField = ReceptanceTable | str
    FmuField = LinearController | str
    TableSource = ReceptanceTable | str | Path | None


def is_rotor(value: object) -> TypeIs[Rotor]:
    """Return whether a value is a rotor, without importing the rotor classes, which a run by name does not need."""
    return _is(value, "rotor_analysis.rotor", "Rotor")


def is_table(value: object) -> TypeIs[ReceptanceTable]:
    """Return whether a value is a table of receptances, without importing its class."""
    return _is(value, "amb_cosim.model_constants.receptance_file", "ReceptanceTable")


def is_controller(value: object) -> TypeIs[LinearController]:
    """Return whether a value is a linear controller, without importing its class."""
    return _is(value, "amb_cosim.controllers.linear_controller", "LinearController")


def _is(value: object, module: str, name: str) -> bool:
    loaded = sys.modules.get(module)
    return loaded is not None and isinstance(value, getattr(loaded, name))


def named(value: object) -> object:
    """Return the name of a rotor, a table's rotor, or a controller's model; return names and paths unchanged."""
    if is_controller(value):
        return value.model
    return value.name if is_rotor(value) else value.rotor if is_table(value) else value


def table_source(receptances: TableSource) -> ReceptanceTable | Path | None:
    """Return a table of receptances, or the path of its file."""
    return Path(receptances) if isinstance(receptances, str) else receptances


def _unless(is_made: Callable[[object], bool]) -> Callable[[object, ValidatorFunctionWrapHandler], Any]:
    """Return a validator that leaves objects made in Python unchanged."""
    return lambda value, validate: value if is_made(value) else validate(value)


def _as_data(value: object, _: SerializerFunctionWrapHandler) -> Any:
    if is_table(value) or is_controller(value):
        return repr(value)
    return TypeAdapter(type(value)).dump_python(value, mode="json", exclude_none=True) if is_rotor(value) else value


if not TYPE_CHECKING:
    RotorSource = TableSource = Any
    RotorField = Annotated[str, Checked(_unless(is_rotor)), Serialised(_as_data)]
    TableField = Annotated[str, Checked(_unless(is_table)), Serialised(_as_data)]
    FmuField = Annotated[str, Checked(_unless(is_controller)), Serialised(_as_data)]
