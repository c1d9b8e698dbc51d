"""Sweeps that come with the package, by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from amb_cosim.studies.recovery_trials import CONTROLS


@dataclass(frozen=True)
class ReadySweep:
    """A scenario and what is varied, as arguments of `amb_cosim.sweep`."""

    scenario: str
    options: Mapping[str, Any] = field(default_factory=dict)


COMPARED: dict[str, dict[str, Any]] = {
    name: {f"rolac_controller.{key}": raw for key, raw in CONTROLS[name].items()}
    for name in ("PID", "PID + OLAC", "PID + ROLAC", "PID + contact-aware ROLAC")
}

READY: dict[str, ReadySweep] = {
    "recovery": ReadySweep(  # which control frees the rotor of Fig. 5.6, over speed and step of unbalance
        "fig5_6",
        {
            "vary": {
                "control": COMPARED,
                "Omega": "14 Hz:18 Hz:9",
                "step.rotor_contact.d1.u": "10 g.m:45 g.m:15",
            },
            "boundary": "recovered",
        },
    ),
    "phase": ReadySweep(  # how hard a fall is over the angle of its unbalance when the bearings lose their power
        "drop",
        {"vary": {"step.cycle": "0:1:17", "rotor_contact.d?.u": "0.23 g.m:2.3 g.m:4"}, "until": 0.1},
    ),
    "rolling": ReadySweep(  # which friction makes the rotor of Fig. 4.18 roll, over its speed
        "fig4_18",
        {"vary": {"Omega": "60:240:10", "rotor_contact.rb?.mu": "0.1:2:20"}, "boundary": "rolling"},
    ),
    "touchdown": ReadySweep(  # what a fall leads to, over speed and friction
        "drop",
        {"vary": {"Omega": "100:400:7", "rotor_contact.rb?.mu": "0.05:0.5:7"}, "until": 0.3, "boundary": "rolling"},
    ),
    "sensitivity": ReadySweep(  # which parameter decides on the peak force of Fig. 4.9
        "fig4_9",
        {
            "vary": {
                "step.rotor_contact.d1.u": "20 g.m:30 g.m",
                "rotor_contact.rb?.clearance": "0.65 mm:0.85 mm",
                "rotor_contact.rb?.mu": "0:0.3",
                "Omega": "250:270",
            },
            "sample": "saltelli:64",
        },
    ),
}
