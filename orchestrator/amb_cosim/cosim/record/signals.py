"""Recorded signals over time with labels, for summaries, figures and files.

`SignalTable` provides the required attributes of `xarray.Dataset` under the same names. Importing xarray takes as long
as a short run, so it is loaded only when a data set is requested.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr


EACH_STEP = "step_time"  # the times of all steps, where a record is thinned
AT_STEPS = ".steps"


class Labelled(Protocol):
    """Samples with their attributes (units, description, ...)."""

    @property
    def values(self) -> NDArray[Any]: ...
    @property
    def attrs(self) -> Mapping[Any, Any]: ...


class Signals(Protocol):
    """Signals over `time`, by name, with attributes of the run: a `SignalTable` or an `xarray.Dataset`."""

    @property
    def attrs(self) -> Mapping[Any, Any]: ...
    @property
    def sizes(self) -> Mapping[Any, int]: ...
    def __getitem__(self, name: str, /) -> Labelled: ...
    def __contains__(self, name: object, /) -> bool: ...


def variables_of(signals: Signals) -> list[str]:
    """Return the names of all variables, including those that are recorded at every step."""
    return list(signals.variables if isinstance(signals, SignalTable) else signals.data_vars)  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Samples:
    """Samples of a variable over a coordinate, shape (n,), with their attributes."""

    values: NDArray[Any]
    attrs: Mapping[str, str]
    over: str = "time"


@dataclass(frozen=True)
class SignalTable:
    """Variables and coordinates over the dimension `time`, by name, with attributes of the run.

    Variables that a decimated record contains at every step use the dimension `EACH_STEP`; their names end with
    `AT_STEPS`.
    """

    variables: Mapping[str, Samples]
    coordinates: Mapping[str, Samples]
    attrs: Mapping[str, Any]

    @property
    def sizes(self) -> Mapping[str, int]:
        """Number of samples, as `sizes["time"]`."""
        return {"time": len(self.coordinates["time"].values)}

    def __getitem__(self, name: str, /) -> Samples:
        return self.coordinates[name] if name in self.coordinates else self.variables[name]

    def __contains__(self, name: object, /) -> bool:
        return name in self.variables or name in self.coordinates

    def to_dataset(self) -> xr.Dataset:
        """Return the table as an xarray data set that shares its samples."""
        import xarray as xr

        data, coordinates = (
            {name: (variable.over, variable.values, dict(variable.attrs)) for name, variable in group.items()}
            for group in (self.variables, self.coordinates)
        )
        return xr.Dataset(data, coordinates, dict(self.attrs))
