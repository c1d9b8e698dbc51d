"""The warnings of a run in the words and units of its summary.

FMUs state their warnings in SI units and with the names of variables. Here speeds are in the unit chosen for speeds. A
whirl that is compared with a natural frequency is in the unit chosen for frequencies. Sites that are switched off share
a single sentence.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import WarningRecord, sentences
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import frequency_unit, length_unit, speed_unit, with_speeds_in
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.signal_arrays import parameters, signal

PASSED, BEYOND = ".passed", ".beyond_reduction"


def warning_sentences(warned: Sequence[WarningRecord], dataset: Signals) -> list[str]:
    """Return a sentence for each kind of warning of a run."""
    off = [record for record in warned if record.component == PLANT and record.variable.endswith(PASSED)]
    beyond = [record for record in warned if record.variable.endswith(BEYOND)]
    others = [record for record in warned if record not in off and record not in beyond]
    passed = _passed_where_off([record.variable.removesuffix(PASSED) for record in off], dataset)
    return [
        *([passed] if passed else sentences(off)),
        *(with_speeds_in(text, frequency_unit()) for text in sentences(beyond)),
        *(with_speeds_in(text, speed_unit()) for text in sentences(others)),
    ]


def _passed_where_off(sites: Sequence[str], dataset: Signals) -> str:
    """Return how far the rotor was beyond the clearances of sites that are switched off, and when; empty if unknown.

    The gap is the clearance minus the displacement; it is negative if the rotor would have touched.
    """
    depths, times = list[tuple[float, float]](), list[float]()
    for site in sites:
        gap, clearance = signal(dataset, f"{site}.gap"), parameters(dataset).get(f"{site}.clearance")
        if gap is None or clearance is None or not (gap < 0.0).any():
            return ""
        depths.append((float(-gap.min()), float(clearance)))
        times += dataset["time"].values[gap < 0.0][[0, -1]].tolist()
    if not depths:
        return ""
    depth, clearance = max(depths)
    names = [name_label(site) for site in sites]
    listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
    lengths = f"{length_unit(depth).text(depth, 3)} beyond the clearance of {length_unit(clearance).text(clearance, 3)}"
    first, last = np.min(times), np.max(times)
    return (
        f"{listed} {'is' if len(names) == 1 else 'are'} switched off ({sites[0]}.enabled = false); the rotor would "
        f"have touched there (up to {lengths}, {first:.3f} to {last:.3f} s)"
    )
