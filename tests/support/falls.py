"""A run in which a rotor falls onto its retainers, as known functions of time."""

import json

import numpy as np
import xarray as xr

from amb_cosim.results.places import RotorPlaces

H, PERIOD, CLEARANCE = 1e-3, 0.02, 0.75e-3
RELEASE, LANDED, WHIRLED, END = 0.1, 0.2, 1.2, 3.0  # s: fall, whirl around the retainer, rest at its bottom
DOWN = 1.25 * np.pi
OMEGA, WHIRL = 300.0, -40.0  # rad/s


def fall(gravity=9.81, **replaced) -> xr.Dataset:
    """Return a fall of both journals onto their retainers, with backward whirl at 40 rad/s, then rest.

    The rotor falls 0.75 mm, RB2 is touched 50 ms later, the spin falls to nothing within 2 s.
    """
    t = np.arange(-0.05, END + H / 2, H)
    fallen = np.clip((t - RELEASE) / (LANDED - RELEASE), 0.0, 1.0) * CLEARANCE
    angle = DOWN + np.where(t < WHIRLED, np.clip(t - LANDED, 0.0, None), 0.0) * WHIRL
    x, y = fallen * np.cos(angle), fallen * np.sin(angle)
    variables: dict[str, np.ndarray] = {"speed": np.clip(OMEGA * (1.0 - (t - RELEASE) / 2.0), 0.0, OMEGA)}
    for bearing in ("mb1", "mb2"):
        variables[f"{bearing}.x"], variables[f"{bearing}.y"] = x, y
    for site, begin in (("rb1", LANDED), ("rb2", LANDED + 0.05)):
        touches = t > begin
        whirls = touches & (t < WHIRLED)
        variables[f"{site}.mode"] = np.where(whirls, 1, np.where(touches, 2, 0))
        variables[f"{site}.f_n"] = np.where(touches, 450.0, 0.0)
        variables[f"{site}.impulse"] = np.zeros(len(t))
        variables[f"{site}.whirl_speed"] = np.where(t < WHIRLED, WHIRL, 0.0)
        variables[f"{site}.friction_power"] = np.where(whirls, 200.0, 0.0)
        variables[f"{site}.heat"] = 5.0 + 200.0 * np.cumsum(whirls) * H
        variables[f"{site}.race_speed"] = np.clip((t - begin) * 500.0, 0.0, 100.0)
        variables[f"{site}.temperature"] = np.full(len(t), 300.0)
    for k, (site, impulse) in enumerate((("rb1", 3.0), ("rb2", 2.0), ("rb1", 1.0), *[("rb2", 0.5)] * 5)):
        variables[f"{site}.impulse"][np.argmax(t > LANDED) + 10 * k] = impulse
    variables["contact_state"] = (variables["rb1.mode"] > 0) + 2 * (variables["rb2.mode"] > 0)
    variables |= replaced
    off = "amb_actuator.mb1.amplifier_off_x"
    parameters = {
        "gravity": gravity,
        "gravity_angle": DOWN,
        "spin.free": 1.0,
        "rb1.clearance": CLEARANCE,
        "rb2.clearance": CLEARANCE,
        "rb2.heat_capacity": 100.0,
    }
    return xr.Dataset(
        {f"rotor_contact.{name}": ("time", values) for name, values in variables.items()}
        | {off: ("time", t >= RELEASE)},
        {"time": ("time", t), "cycle": ("time", t / PERIOD)},
        {
            "scenario": "fall",
            "flavour": "native",
            "completed": 1,
            "settling_s": 0.05,
            "simulated_s": END,
            "wall_s": 0.1,
            "speed_rad_s": OMEGA,
            "period_s": PERIOD,
            "places": RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2"), magnetic=("mb1",)).to_json(),
            "parameters": json.dumps({"rotor_contact": parameters}),
        },
    )
