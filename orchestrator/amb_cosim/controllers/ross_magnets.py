"""Files that levitate a rotor saved by ROSS with magnetic bearings: a controller with its PID law, and a scenario."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import tomli_w

from rotor_analysis.ross_magnets import SavedMagnet

SAMPLE_TIME = "5 us"  # ROSS has no sampling; a delay of 10 us excites undamped modes near 10 kHz
AXES = "xy"


def levitation_files(name: str, rotor: str, magnets: Mapping[str, SavedMagnet]) -> dict[str, str]:
    """Return the texts of `NAME_controller.toml` and `NAME_levitation.toml`, by file name.

    i = -k_amp k_sense (k_p x + k_I int x dt + k_d x'),   2 mu_0 A N^2 = mu_0 n_w^2 a_g/2     (1)

    ROSS counts the turns n_w of two poles in series, whereas the actuator counts the turns of one pole, N = n_w/2; the
    pole area is the same.

    Parameters
    ----------
    name
        First part of the files' names.
    rotor
        Name of the rotor file that the scenario is for.
    magnets
        The magnetic bearings by their names in the rotor file; each has a sensor `NAME_probe`.
    """
    controller = {
        "inputs": [f"{of}_probe.{axis}" for of in magnets for axis in AXES],
        "outputs": [f"{of}.i_{axis}" for of in magnets for axis in AXES],
        "sample_time": SAMPLE_TIME,
        "limits": [f"{sign * min(magnet.i0 for magnet in magnets.values())} A" for sign in (-1, 1)],
        "channel": [_channel(of, magnet) for of, magnet in magnets.items()],
    }
    law = f"{name}_controller.toml"
    scenario = {
        "description": "Levitation by the PID control that the magnets have in ROSS, without gravity",
        "rotor": rotor,
        "fmu": {"rolac_controller": law},
        "Omega": "100 rad/s",
        "gravity": "0 m/s2",
        "communication_step": SAMPLE_TIME,
        "settle_cycles": 10,
        "end_cycle": 20,
        "parameters": {
            "amb_actuator": {"force_law": "linear", "amplifier": "ideal"}
            | {key: value for of, magnet in magnets.items() for key, value in _magnet(of, magnet).items()}
        },
    }
    return {law: tomli_w.dumps(controller), f"{name}_levitation.toml": tomli_w.dumps(scenario)}


def _channel(name: str, magnet: SavedMagnet) -> dict[str, Any]:
    pid = {
        "type": "pid",
        "kp": f"{magnet.kp_pid!r} A/m",
        "ki": f"{magnet.ki_pid!r} A/(m.s)",
        "kd": f"{magnet.kd_pid!r} A.s/m",
        "roll_off": f"{magnet.n_f / math.tau!r} Hz",
    }
    return {
        "from": [f"{name}_probe.{axis}" for axis in AXES],
        "to": [f"{name}.i_{axis}" for axis in AXES],
        "gain": -magnet.k_amp * magnet.k_sense,
        "blocks": [pid],
    }


def _magnet(name: str, magnet: SavedMagnet) -> dict[str, Any]:
    values = {
        "turns": 0.5 * magnet.nw,
        "pole_area": f"{magnet.ag!r} m2",
        "gap": f"{magnet.g0!r} m",
        "half_angle": f"{magnet.alpha!r} rad",
        "bias_current": f"{magnet.i0!r} A",
        "static_current": "0 A",
        "current_limit": f"{2.0 * magnet.i0!r} A",
    }
    return {f"{name}.{key}_?": value for key, value in values.items()}
