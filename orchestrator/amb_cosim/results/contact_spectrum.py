"""The share of the contact force above the frequency up to which the reduced rotor is accurate."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import frequency_unit
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import at_every_step, cycles, signal, thinning
from array_types import Array

WARNED_SHARE = 0.1
_SEGMENT = 256  # samples of a spectrum; of several, half overlapping, the mean is taken


def share_beyond_reduction(dataset: Signals) -> dict[str, float | None]:
    """Return the share of a normal contact force's power above the frequency up to which the reduction is valid.

        share = sum(S(omega), omega > valid_to) / sum(S(omega))

    S is the power spectrum of `f_n` from cycle 0 on, estimated by Welch's method up to half the sampling frequency. S
    does not include the impulses of impacts, which have equal power at all frequencies.

    Returns
    -------
    dict
        The share at each site of `contact_history.touchable` other than faces. The share is None if the reduction is
        valid without a limit, or if the force is zero or was not recorded at every step.
    """
    faces = places(dataset).faces
    return {site: _share(dataset, site) for site in touchable(dataset) if site not in faces}


def warnings_beyond_reduction(dataset: Signals) -> list[str]:
    """Return a sentence if more than `WARNED_SHARE` of the force's power at any site is above the reduction's limit."""
    shares = {site: share for site, share in share_beyond_reduction(dataset).items() if share is not None}
    warned = [f"{name_label(site)} {100.0 * share:.3g} %" for site, share in shares.items() if share > WARNED_SHARE]
    limit = places(dataset).valid_to
    if not warned or limit is None:
        return []
    above, allowed = frequency_unit().text(limit), f"{100.0 * WARNED_SHARE:.3g} %"
    return [
        f"much of the contact force's power is above {above}, where the reduced rotor is no longer accurate: "
        f"{', '.join(warned)} (allowed: {allowed}); retain more modes in the reduction"
    ]


def _share(dataset: Signals, site: str) -> float | None:
    dataset = at_every_step(dataset)
    force, limit = signal(dataset, f"{site}.f_n"), places(dataset).valid_to
    after = cycles(dataset) >= 0.0
    if force is None or limit is None or thinning(dataset) > 1:
        return None
    if np.count_nonzero(after) < 2 or not force[after].any():
        return None
    steps = np.diff(dataset["time"].values[after])
    if not np.allclose(steps, steps[0], rtol=1e-6):
        return None
    omega, power = _spectrum(force[after], float(steps[0]))
    total = power.sum()
    return float(power[omega > limit].sum() / total) if total > 0.0 else None


def _spectrum(values: Array, h: float) -> tuple[Array, Array]:
    """Return frequencies (rad/s) and the power at each of them, up to a constant factor.

    The results are those of `scipy.signal.welch`, except that samples left over at the end have their own segment.
    SciPy is not used because importing it takes longer than a run.
    """
    size = min(_SEGMENT, len(values))
    last = len(values) - size
    begins = np.unique([*range(0, last, max(1, size // 2)), last])
    segments = sliding_window_view(values, size)[begins] * np.hanning(size + 1)[:-1]
    power = np.mean(np.abs(np.fft.rfft(segments)) ** 2, axis=0)
    power[1 : (size + 1) // 2] *= 2.0  # adds the power at negative frequencies
    return np.asarray(2.0 * np.pi * np.fft.rfftfreq(size, h), np.float64), np.asarray(power, np.float64)
