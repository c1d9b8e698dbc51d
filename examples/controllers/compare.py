"""Controllers for one compressor side by side: sensitivity, disk margin, and the unbalance step that they hold."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from h_infinity import h_infinity
from lqg import AXES, SCENARIO, lqg

import amb_cosim
from amb_cosim import studies
from rotor_analysis.reduced_rotor import with_modes_up_to
from rotor_analysis.rotor_file import load_rotor

HERE = Path(__file__).parent
ROTOR = with_modes_up_to(load_rotor("compressor"), 2.0 * np.pi * 1e4)  # all modes up to the sample rate


def controllers():
    """Return the controllers by name; None is the PID of the scenario."""
    return {
        "PID": None,
        "lead with two sections": HERE / "lead_notches.toml",
        "cross-feedback": HERE / "cross_feedback.toml",
        "LQG": lqg(),
        "H-infinity": h_infinity()[0],
    }


def compared(controller):
    """Return margins and run of the compressor under a controller."""
    margins = studies.sensitivity(SCENARIO, controller=controller)
    fmu = None if controller is None else {"rolac_controller": controller}
    return margins, amb_cosim.run(SCENARIO, rotor=ROTOR, fmu=fmu, progress=False)


def summary(margins, run):
    """Return peak, disk margin of the currents and outcome as text."""
    peak, disk = max(axis.peak for axis in margins.axes.values()), margins.disk_margins["currents"]
    return f"peak {peak:.2f}, disk margin {disk.least:.2f} at {disk.frequency:.0f} Hz, {run.summary.recovery}"


def draw(found, path):
    """Draw the largest |S| of the axes, the disk margins at the currents, and the largest displacement over time."""
    figure, (top, middle, bottom) = plt.subplots(3, 1, figsize=(8.0, 9.0), layout="constrained")
    for name, (margins, run) in found.items():
        highest = np.max([axis.computed for axis in margins.axes.values()], axis=0)
        top.semilogx(margins.frequencies, highest, lw=0.9, label=name)
        middle.semilogx(margins.frequencies, margins.disk_margins["currents"].alpha, lw=0.9)
        moved = np.max([np.abs(run.signals[f"rotor_contact.{axis}"].values) for axis in AXES], axis=0)
        bottom.plot(run.signals["time"].values, 1e6 * moved, lw=0.7)
    top.set(ylabel="largest |S| of the axes", ylim=(0.0, 3.0))
    middle.set(ylabel="disk margin, all currents", xlabel="frequency (Hz)", ylim=(0.0, 2.0))
    bottom.set(ylabel="largest displacement (um)", xlabel="time (s)")
    top.legend(ncols=2)
    figure.savefig(path, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    found = {name: compared(controller) for name, controller in controllers().items()}
    for name, (margins, run) in found.items():
        print(f"{name}: {summary(margins, run)}")
    draw(found, "controllers.png")
