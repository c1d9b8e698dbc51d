"""Results of all studies: a record that can be printed, written as JSON and drawn."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from amb_cosim.presentation.json_data import json_data, units_of
from amb_cosim.presentation.text_tables import TextBlock, html_of, rendered

LONGEST = 60  # characters of a value in a result's representation


class StudyResult:
    """Base of the frozen dataclasses that studies return. `print` shows their tables.

    `units` has the units of their fields. A name has one unit in all of them: a speed is in rad/s, a spin frequency in
    Hz.
    """

    renamed: ClassVar[Mapping[str, str]] = {}
    """New names of former fields, for the error of an access to them."""

    @property
    def units(self) -> dict[str, str]:
        """Units of the fields that have one, by field."""
        return units_of(type(self))

    if not TYPE_CHECKING:  # type checkers know the fields

        def __getattr__(self, name: str) -> NoReturn:
            """Refuse a field that does not exist; name the new field if it was renamed."""
            new = f"; it is now {self.renamed[name]}" if name in self.renamed else ""
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}{new}")

    def as_dict(self) -> dict[str, Any]:
        """Return the data for JSON; the keys include the units."""
        data: dict[str, Any] = json_data(self)
        return data

    def to_json(self, indent: int = 2) -> str:
        """Return the JSON text of `as_dict`."""
        return json.dumps(self.as_dict(), indent=indent, allow_nan=False) + "\n"

    def text(self) -> list[TextBlock]:
        """Return the tables and lines that describe the result."""
        raise NotImplementedError

    def __str__(self) -> str:
        return rendered(self.text())

    def _repr_html_(self) -> str:
        return html_of(self.text())

    def __repr__(self) -> str:
        fields = dataclasses.fields(self)  # type: ignore[arg-type]  # every result is a dataclass
        return f"{type(self).__name__}({', '.join(f'{f.name}={_short(getattr(self, f.name))}' for f in fields)})"


class DrawnResult(StudyResult):
    """A result that `amb_analysis.studies.figure` draws."""

    name: ClassVar[str]
    """Name of the study, of its files, and of the module in `figures` that draws it."""

    def data_files(self) -> dict[str, str]:
        """Return the text of each data file, by file name."""
        return {f"{self.name}.json": self.to_json(indent=1)}


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class WarnedResult(StudyResult):
    """A result with warnings.

    warnings
        Warnings of the run's plan, as in the summary of a run; for a rotor alone, warnings about implausible sizes.
    """

    warnings: tuple[str, ...] = dataclasses.field(default=(), kw_only=True)

    def warning_lines(self) -> list[TextBlock]:
        """Return the warnings as lines for `text`."""
        return [f"warning: {sentence}" for sentence in self.warnings]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class MachineResult(WarnedResult, DrawnResult):
    """A result of a study that treats the machine of a scenario.

    scenario, rotor
        Name of the scenario that defines the parameters, and name of its rotor.
    """

    scenario: str
    rotor: str


def _short(value: Any) -> str:
    """Represent a value in one line: an array by its shape, and other long values by their type."""
    if isinstance(value, np.ndarray):
        return f"<array of shape {value.shape}>"
    text = repr(value)
    return text if len(text) <= LONGEST else f"<{type(value).__name__}>"
