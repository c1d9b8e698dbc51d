"""Record of the steady response to unbalance, with its tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, is_extrapolated, limit_notes
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.presentation.units import ShownUnit, length_unit, speed_unit
from array_types import Array
from rotor_analysis.peaks import UNDAMPED
from rotor_analysis.shaft import MassModel

RESTING = 1e-9  # motion over the median amplitude, and semi-axis ratio, up to which an orbit has no sense of whirl
DAMPED = 2.5  # amplification below which a peak needs no separation margin (API 617)


@dataclass(frozen=True, eq=False)
class PlaceResponse:
    """Response at a point of the shaft.

    node
        Number of the node on the mesh, which may have more nodes than the rotor file numbers.
    z
        Axial position (m).
    amplitude
        Major semi-axis of the orbit (m), shape (n,).
    minor
        Minor semi-axis (m), shape (n,), negative where the orbit is backward. The product of pi and both semi-axes is
        therefore the signed area of the orbit, positive for forward whirl.
    phase
        Angle by which the forward part of the motion leads the unbalance (rad), continuous, shape (n,).
    clearance
        Smallest radial clearance (m) of all places at this node, each reduced by the offset of its centre; None if the
        rotor cannot touch anything there.
    """

    node: int
    z: Annotated[float, "m"]
    clearance: Annotated[float | None, "m"]
    amplitude: Annotated[Array, "m"]
    phase: Annotated[Array, "rad"]
    minor: Annotated[Array, "m"]

    def backward(self, speeds: Array) -> list[tuple[float, float]]:
        """Return the ranges of speed (rad/s) in which the orbit is backward, interpolated between the samples."""
        moves = self.amplitude > RESTING * np.median(self.amplitude)
        ratio = np.where(moves, self.minor / np.where(moves, self.amplitude, 1.0), 0.0)
        whirls = np.concatenate([[False], ratio < -RESTING, [False]])
        begins, ends = np.flatnonzero(whirls[1:] & ~whirls[:-1]), np.flatnonzero(whirls[:-1] & ~whirls[1:]) - 1
        return [
            (_zero(speeds, ratio, first - 1, first), _zero(speeds, ratio, last, last + 1))
            for first, last in zip(begins.tolist(), ends.tolist(), strict=True)
        ]


@dataclass(frozen=True)
class PlacedUnbalance:
    """An unbalance (kg m), and the angle (deg) by which the unbalance leads the x axis at the beginning of a turn."""

    amount: Annotated[float, "kg.m"]
    angle: Annotated[float, "deg"]


@dataclass(frozen=True)
class CriticalResponse:
    """A peak of the response.

    place
        Place of the highest amplitude.
    speed, amplitude
        Spin speed (rad/s) and amplitude (m) of the peak.
    amplification
        Amplification from the half-power width (`rotor_analysis.peaks`); below 2.5 no separation margin is required
        (API 617).
    margin
        Distance from the operating speed (%), never negative; None for a rotor alone.
    extrapolated
        Whether the speed is outside a table of coefficients.
    """

    place: str
    speed: Annotated[float, "rad/s"]
    amplitude: Annotated[float, "m"]
    amplification: float
    margin: Annotated[float | None, "%"]
    extrapolated: bool = False

    def required_margin(self, operating: float) -> float | None:
        """Return the margin (%) from an operating speed (rad/s) that API 617 requires; None if the peak is damped.

        The margin is min(16, 17 (1 - 1/(AF - 1.5))) for a peak below the operating speed, and
        min(26, 10 + 17 (1 - 1/(AF - 1.5))) for a peak above it.
        """
        if self.amplification < DAMPED:
            return None
        share = 17.0 * (1.0 - 1.0 / (self.amplification - 1.5))
        return min(26.0, 10.0 + share) if self.speed > operating else min(16.0, share)

    @property
    def is_bounded(self) -> bool:
        """Whether damping rather than rounding limits the peak."""
        return self.amplification < UNDAMPED


@dataclass(frozen=True, eq=False, repr=False)
class UnbalanceResponse(WarnedResult, DrawnResult):
    """Steady response of a rotor, or of a levitated machine, to unbalance.

    rotor, mass
        Name of the rotor, and the mass matrix of its model.
    scenario, operating_speed
        Name of the machine's scenario, and spin speed of the machine (rad/s); both are None for a rotor alone.
    unbalance, z
        Largest unbalance of a node (kg m), which is the sum over the places at the node, and the position of this node
        (m).
    unbalances
        Unbalance of each place, by name.
    speeds
        Spin speeds (rad/s), ascending, shape (n,).
    places
        Response at bearings, other contact sites, and shaft ends, by name.
    critical_speeds
        Peaks of the response, ascending.
    limits
        Validity limits of the coefficients of bearings and seals.
    floating
        Number of rigid-body motions, out of four, that no bearing or seal restrains with stiffness.
    stable_up_to
        Speed (rad/s) at which the response ends because the loop of the machine is unstable above it; otherwise None.
    """

    name: ClassVar[str] = "unbalance_response"

    rotor: str
    mass: MassModel
    scenario: str | None
    operating_speed: Annotated[float | None, "rad/s"]
    unbalance: Annotated[float, "kg.m"]
    z: Annotated[float, "m"]
    unbalances: dict[str, PlacedUnbalance]
    speeds: Annotated[Array, "rad/s"]
    places: dict[str, PlaceResponse]
    critical_speeds: tuple[CriticalResponse, ...]
    limits: Limits = ()
    stable_up_to: Annotated[float | None, "rad/s"] = None
    floating: int = 0

    @property
    def load(self) -> str:
        """Description of the unbalance in words."""
        amounts = (f"{_gram_metres(u.amount)} at {place}" for place, u in self.unbalances.items())
        return ", ".join(amounts)

    def text(self) -> list[TextBlock]:
        """Return tables of the largest amplitudes and of the critical speeds."""
        name = self.scenario or self.rotor
        unit = speed_unit()
        peaks = [place.amplitude.max() for place in self.places.values()] + [c.amplitude for c in self.critical_speeds]
        length = length_unit(max((float(peak) for peak in peaks if np.isfinite(peak)), default=0.0))
        heads: tuple[str, ...] = (f"amplitude ({length.label})", "of the clearance", f"speed ({unit.label})")
        table = labelled_table(f"{name}: largest amplitude, {self.load}", "place", *heads)
        for name, place in self.places.items():
            top = int(np.argmax(place.amplitude))
            peak = place.amplitude[top]
            mark = f" {EXTRAPOLATED}" if is_extrapolated(self.limits, self.speeds[top]) else ""
            if any(abs(item.speed / self.speeds[top] - 1.0) < 1.0 / UNDAMPED for item in self._unbounded):
                table.add_row(name, "no bound", "-", f"{unit.number(self.speeds[top])}{mark}")
                continue
            share = "-" if place.clearance is None else number(peak / place.clearance)
            table.add_row(name, number(peak / length.size), share, f"{unit.number(self.speeds[top])}{mark}")
        notes = list[TextBlock](limit_notes(self.limits, self.speeds))
        if self.stable_up_to is not None:
            notes = [f"the loop is not stable above {unit.text(self.stable_up_to, 5)}", *notes]
        notes = [*self._floating_note(), *self._backward_notes(), *notes, *self.warning_lines()]
        if not self.critical_speeds:
            return [self._answer(length), table, *notes]
        heads = (f"speed ({unit.label})", "highest at", f"amplitude ({length.label})", "amplification")
        heads += () if self.operating_speed is None else (f"margin to {unit.text(self.operating_speed, 5)} (%)",)
        criticals = labelled_table(f"Critical speeds with {self.load}", *heads)
        for item in self.critical_speeds:
            speed = unit.number(item.speed) + (f" {EXTRAPOLATED}" if item.extrapolated else "")
            amplitude = number(item.amplitude / length.size) if item.is_bounded else "no bound"
            row = (speed, item.place, amplitude, amplification_text(item))
            criticals.add_row(*row, *(() if item.margin is None else (f"{item.margin:.1f}",)))
        undamped = ", ".join(unit.text(item.speed) for item in self._unbounded)
        return [
            self._answer(length),
            table,
            criticals,
            *([f"nothing damps the motion at {undamped}"] if undamped else []),
            *notes,
        ]

    def _answer(self, length: ShownUnit) -> str:
        """Return the number of critical speeds, the largest amplitude, and the place nearest to contact."""
        unit, n = speed_unit(), len(self.critical_speeds)
        count = f"{n} critical speed{'s' * (n != 1)}" if n else "no critical speed"
        within = f"{count} up to {unit.text(self.speeds[-1])}"
        if self._unbounded:
            return (
                f"{within}; the response is unbounded at {unit.text(self._unbounded[0].speed)}, where nothing damps it"
            )
        tops = {name: (float(place.amplitude.max()), place) for name, place in self.places.items()}
        name = max(tops, key=lambda of: tops[of][0])
        at = self.speeds[int(np.argmax(tops[name][1].amplitude))]
        largest = f"largest amplitude {length.text(tops[name][0])} at {name} and {unit.text(at)}"
        shares = {of: peak / place.clearance for of, (peak, place) in tops.items() if place.clearance is not None}
        if not shares:
            return f"{within}; {largest}"
        nearest = max(shares, key=lambda of: shares[of])
        touches = "; there the rotor touches, so this linear response is not valid" if shares[nearest] > 1.0 else ""
        return (
            f"{within}; {largest}; {significant(100.0 * shares[nearest], 3)} % of the clearance at {nearest}{touches}"
        )

    def _floating_note(self) -> list[str]:
        if not self.floating:
            return []
        return [
            f"bearings and seals do not hold {self.floating} of the 4 rigid-body motions; in these motions the rotor "
            "floats: only inertia and damping limit its response, and there is no critical speed"
        ]

    def _backward_notes(self) -> list[str]:
        """Return lines about the speeds and places at which the rotor whirls backward under unbalance."""
        unit, at = speed_unit(), dict[tuple[str, str], list[str]]()
        for name, place in self.places.items():
            for low, high in place.backward(self.speeds):
                at.setdefault((unit.number(low), unit.text(high)), []).append(name)
        return [
            f"under unbalance, the rotor whirls backward from {low} to {high} at {', '.join(names)}"
            for (low, high), names in at.items()
        ]

    @property
    def _unbounded(self) -> list[CriticalResponse]:
        return [item for item in self.critical_speeds if not item.is_bounded]


def _zero(speeds: Array, values: Array, first: int, second: int) -> float:
    """Return the speed (rad/s) of a zero crossing between two samples, or of one sample if the other is missing."""
    if first < 0 or second >= len(speeds):
        return float(speeds[max(first, 0) if second >= len(speeds) else second])
    return float(speeds[first] + (speeds[second] - speeds[first]) * values[first] / (values[first] - values[second]))


def amplification_text(item: CriticalResponse) -> str:
    """Return an amplification as text, with `(damped)` if no separation margin is required."""
    if not item.is_bounded:
        return "no bound"
    return f"{item.amplification:.3g}" + (" (damped)" if item.amplification < DAMPED else "")


def _gram_metres(u: float) -> str:
    return f"{1e3 * u:.4g} g m" if u >= 1e-3 else f"{1e6 * u:.4g} g mm"
