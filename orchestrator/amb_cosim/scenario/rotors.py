"""The rotor of a scenario: the name of a packaged rotor, a rotor file, or a rotor created in Python."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import SerializerFunctionWrapHandler, TypeAdapter, ValidatorFunctionWrapHandler
from pydantic import WrapSerializer as Serialised
from pydantic import WrapValidator as Checked

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from rotor_analysis.rotor import Rotor
    from rotor_analysis.rotor_file import RotorSource as RotorSource

    RotorField = Rotor | str


def is_rotor(value: object) -> TypeIs[Rotor]:
    """Return whether a value is a rotor, without importing its classes, which a run by name does not need."""
    module = sys.modules.get("rotor_analysis.rotor")
    return module is not None and isinstance(value, module.Rotor)


def named(rotor: Rotor | str | None) -> str | None:
    """Return the name of a rotor, or its name or path unchanged."""
    return rotor.name if is_rotor(rotor) else rotor


def _checked(value: object, of_text: ValidatorFunctionWrapHandler) -> Any:
    return value if is_rotor(value) else of_text(value)


def _as_data(value: object, of_text: SerializerFunctionWrapHandler) -> Any:
    return TypeAdapter(type(value)).dump_python(value, mode="json", exclude_none=True) if is_rotor(value) else value


if not TYPE_CHECKING:
    RotorSource = Any
    RotorField = Annotated[str, Checked(_checked), Serialised(_as_data)]
