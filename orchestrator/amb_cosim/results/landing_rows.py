"""Labels and texts of a landing: its whirl, contacts, heat, highest temperature and final speed."""

from __future__ import annotations

from collections.abc import Iterator

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.units import speed_unit, temperature_text
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles, speed
from amb_cosim.results.touchdown import Touchdown


def landing_rows(dataset: Signals, fall: Touchdown) -> Iterator[tuple[str, str]]:
    """Yield labels and texts of a landing; values that were not recorded are left out."""
    if any(item.whirl is not None for item in fall.retainers.values()):
        yield "whirl", whirl_text(fall) or "none"
    touched, retainers = fall.retainers, {*places(dataset).retainers, *places(dataset).second, *places(dataset).faces}
    of_retainers = [name_label(site) for site in touched if site in retainers]
    others = [name_label(site) for site in touched if site not in retainers]
    beside = f", and outside the retainers: {', '.join(others)}" if others else ", nothing else"
    yield "touched", f"{', '.join(of_retainers) or 'no retainer'}{beside}"
    heats = {name_label(site): item.heat for site, item in touched.items() if item.heat is not None}
    if heats:
        most = max(heats, key=lambda site: heats[site])
        largest = f", of which {significant(heats[most], 3)} J at {most}" if len(heats) > 1 else f" at {most}"
        yield "heat in contact", f"{significant(sum(heats.values()), 3)} J{largest}"
        yield "highest temperature", _temperature(dataset, fall)
    turning = speed(dataset)[cycles(dataset) >= 0.0]
    if len(turning):
        yield "speed at the end", speed_unit().text(float(turning[-1]))


def whirl_text(fall: Touchdown) -> str:
    """Return the sites at which the rotor whirled, with direction and mean speed; empty if it did not whirl."""
    whirling = list[str]()
    for site, item in fall.retainers.items():
        if item.whirl not in (None, "none"):
            mean = "" if item.whirl_speed is None else f" (mean {speed_unit().text(abs(item.whirl_speed))})"
            whirling.append(f"{item.whirl} at {name_label(site)}{mean}")
    return ", ".join(whirling)


def _temperature(dataset: Signals, fall: Touchdown) -> str:
    """Return the highest temperature and its site or, if it was not computed, the reason."""
    temperatures = {site: item.temperature for site, item in fall.retainers.items() if item.temperature is not None}
    if not temperatures:
        site = next(iter(fall.retainers))
        at = places(dataset).faces.get(site, site)
        return f"not computed: {at}.heat_capacity is 0" if at else f"not computed: {site} has no retainer"
    hottest = max(temperatures, key=lambda site: temperatures[site])
    return f"{temperature_text(temperatures[hottest])} at {name_label(hottest)}"
