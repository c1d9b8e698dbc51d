"""Search for a controller that damps a machine: PD with roll-off and a shelf for each bearing, on its linear model.

    u = -(k_p + k_d s/(1 + s/omega_r)) (s^2 + 2 d zeta omega s + omega^2)/(s^2 + 2 zeta omega s + omega^2) y        (1)

sampled by Tustin's rule and a sample late. At all speeds given, vibrations near the speeds shall have a logarithmic
decrement of 1.6, which is an amplification of about 2, others up to twice the largest speed 0.2, those beyond 0.03;
|S| of each axis 2.8 at most; and the noise of the sensors shall move no demand by more than is said. The file has the
current limits of the scenario's controller, and no delay of its own if the scenario's chain has one (chain.delay).
A rotor with a thrust disc also gets the axial PID of `amb-cosim new`, which is not searched.

    python search.py levitation.toml --speeds "9000 rpm, 17600 rpm" --pairs left=probe_left,right=probe_right

The controller is written beside the scenario file as found.toml, unless -o names another file. Each generation prints
the best so far. The last line is how far the best is from all that: 0 has all of it. `amb-cosim assess` judges.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import tomli_w
from scipy.linalg import block_diag
from scipy.optimize import differential_evolution
from scipy.signal import bilinear, cont2discrete, lfilter, tf2ss

import amb_cosim
from amb_analysis.machine.machine import Machine
from amb_assessment.first_design.thrust import ROLL_OFF, axial_channel, axial_gains
from amb_cosim.cosim.system.values import quantity
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from linear_controller.interface import NO_LIMIT
from signal_chain.presets import IDEAL, is_on

WANTED, ENOUGH, ABOVE_ZERO = 1.6, 0.2, 0.03  # decrements: near the speeds, up to twice the largest, beyond
LARGEST = 2.8  # |S|, in zone A of ISO 14839-3 as it is remembered
UNSTABLE = 1e3
BOUNDS = (  # of each bearing
    (1.3, 6.0),  # k_p over K_s/K_i
    (-4.3, -2.0),  # power of ten of k_d/k_p in s
    (-1.6, -0.4),  # power of ten of the roll-off over the sample rate
    (-1.7, -0.9),  # the same of the shelf
    (0.1, 1.0),  # its damping zeta
    (0.2, 2.5),  # its depth d
)


class Search:
    """A machine at some speeds, and how far a controller is from what is wanted there."""

    def __init__(self, scenario, speeds, pairs, sample_time, noise=0.0, most_noise=1.0):
        machine = Machine(prepare_run(as_scenario(scenario).machine()))
        self.pairs, self.noise, self.most_noise = pairs, noise, most_noise
        self.step = sample_time = sample_time or machine.loop.sample_time
        self.Omega = [quantity(speed, "rad/s", "speeds") for speed in speeds]
        magnets = [_magnet(scenario, bearing) for bearing in pairs]
        self.k_p = [k_s / k_i for k_i, k_s in magnets]
        self.axial, self.thrust = [], machine.rotor.thrust
        if self.thrust:
            of_axis = *_magnet(scenario, self.thrust, "z"), machine.rotor.mass
            kp, ki, kd = axial_gains(*of_axis)
            omega = 2.0 * np.pi * ROLL_OFF
            ratio = [-kp / omega - kd, -kp - ki / omega, -ki], [1.0 / omega, 1.0, 0.0]
            self.channel, self.axial = axial_channel(self.thrust, *of_axis), [bilinear(*ratio, 1.0 / sample_time)]
        self.limits, self.is_late = _of_controller(machine, pairs)
        rate = 1.0 / sample_time
        hertz = np.concatenate([np.geomspace(1e-4, 0.03, 120), np.linspace(0.03, 0.2, 80)[1:]]) * rate
        self.z = np.exp(2j * np.pi * hertz * sample_time)
        demands = [f"amb_actuator.{b}.i_{axis}" for b in pairs for axis in "xy"]
        shown = [f"rotor_contact.{sensor}.{axis}" for sensor in pairs.values() for axis in "xy"]
        if self.thrust:
            demands.append(f"amb_actuator.{self.thrust}.i_z")
            shown.append(f"rotor_contact.{self.thrust}.z")
        parts = ["rotor_contact", "amb_actuator"]
        self.plants = []
        for speed in speeds:
            model = amb_cosim.linearise(scenario, speed, demands, shown, components=parts)
            A, B, C, _, _ = cont2discrete((model.A, model.B, model.C, model.D), sample_time, "zoh")
            n, m = B.shape
            A, B = np.block([[A, B], [np.zeros((m, n + m))]]), np.vstack([np.zeros((n, m)), np.eye(m)])
            C = np.hstack([C, np.zeros((len(C), m))])
            response = np.stack([C @ np.linalg.solve(z * np.eye(n + m) - A, B) for z in self.z])
            self.plants.append((A, B, C, response))

    def coefficients(self, x):
        """Return for each bearing k_p (A/m), k_d (A s/m), roll-off (Hz), shelf (Hz), zeta and d."""
        rate = 1.0 / self.step
        return [
            (c * k, c * k * 10**lead, rate * 10**roll_off, rate * 10**shelf, zeta, d)
            for (c, lead, roll_off, shelf, zeta, d), k in zip(np.reshape(x, (-1, len(BOUNDS))), self.k_p, strict=True)
        ]

    def cost(self, x):
        """Return how far it is from what is wanted."""
        ratios = [bilinear(*_ratio(*of), 1.0 / self.step) for of in self.coefficients(x)]
        total = sum(5.0 * max(0.0, self.noise * _of_noise(*ratio) / self.most_noise - 1.0) for ratio in ratios)
        of_axes = [ratio for ratio in ratios for _ in "xy"] + self.axial
        gain = np.array([np.polyval(b, self.z) / np.polyval(a, self.z) for b, a in of_axes])
        law = _law(of_axes)
        for plant in self.plants:
            poles = _poles(plant, law, self.step)
            if (fastest := poles.real.max()) > 0.0:
                return UNSTABLE + min(fastest, UNSTABLE)
            total += self._of_decrements(poles)
            S = np.linalg.inv(np.eye(len(gain)) - gain.T[:, :, None] * plant[3])
            peaks = np.abs(np.diagonal(S, axis1=1, axis2=2)).max(axis=0)
            total += 3.0 * np.maximum(peaks - LARGEST, 0.0).sum()
        return float(total)

    def _of_decrements(self, poles):
        vibrations = poles[poles.imag > 1.0]
        omega, decrement = vibrations.imag, -2.0 * np.pi * vibrations.real / vibrations.imag
        near = (omega > 0.8 * min(self.Omega)) & (omega < 1.3 * max(self.Omega))
        low = omega < 2.0 * max(self.Omega)
        asked = ((near, WANTED, 4.0), (low, ENOUGH, 10.0), (~low, ABOVE_ZERO, 60.0))
        return sum(weight * max(0.0, least - decrement[of].min(initial=least)) for of, least, weight in asked)

    def best(self, generations, seed=1):
        """Return coefficients and cost of the best that is found."""
        bounds, self.generation = BOUNDS * len(self.pairs), 0
        found = differential_evolution(
            self.cost,
            bounds,
            maxiter=generations,
            popsize=5,
            seed=seed,
            polish=False,
            callback=self._reported,
        )
        return self.coefficients(found.x), found.fun

    def _reported(self, intermediate_result):
        """Print the best so far, and return whether it has all that is wanted."""
        self.generation += 1
        print(f"generation {self.generation}: {intermediate_result.fun:.3g}", file=sys.stderr, flush=True)
        return intermediate_result.fun <= 0.0

    def text(self, coefficients):
        """Return the controller file."""
        signals = [f"{sensor}.{axis}" for sensor in self.pairs.values() for axis in "xy"]
        demands = [f"{bearing}.i_{axis}" for bearing in self.pairs for axis in "xy"]
        if self.thrust:
            signals, demands = [*signals, f"{self.thrust}.z"], [*demands, f"{self.thrust}.i_z"]
        lines = [f"inputs = {signals}", f"outputs = {demands}", f'sample_time = "{1e6 * self.step:g} us"']
        if not self.is_late:
            lines.append("delay = 1  # sample; without it if chain.delay is on")
        if self.limits:
            lines.append('limits = ["{:.6g} A", "{:.6g} A"]'.format(*self.limits))
        for (bearing, sensor), (k_p, k_d, roll_off, shelf, zeta, d) in zip(
            self.pairs.items(), coefficients, strict=True
        ):
            lines += [
                "",
                "[[channel]]",
                f'from = ["{sensor}.x", "{sensor}.y"]',
                f'to = ["{bearing}.i_x", "{bearing}.i_y"]',
                "gain = -1",
                "blocks = [",
                f'  {{ type = "pid", kp = "{k_p:.5g} A/m", kd = "{k_d:.5g} A.s/m", roll_off = "{roll_off:.5g} Hz" }},',
                f'  {{ type = "notch", frequency = "{shelf:.5g} Hz", damping = {zeta:.4g}, depth = {d:.4g} }},',
                "]",
            ]
        if self.thrust:
            lines += ["", tomli_w.dumps({"channel": [self.channel]}).rstrip()]
        return "\n".join(lines) + "\n"


def _magnet(scenario, bearing, axis="x"):
    """Return K_i (N/A) and K_s (N/m) of an axis of a bearing."""
    magnet = f"amb_actuator.{bearing}"
    inputs, force = [f"{magnet}.i_{axis}", f"{magnet}.{axis}"], [f"{magnet}.f_{axis}"]
    return amb_cosim.linearise(scenario, None, inputs, force, components=["amb_actuator"]).dcgain()[0]


def _of_controller(machine, pairs):
    """Return the narrowest current limits (A) of a machine's controller, if any, and whether its chain has a delay."""
    values = machine.parameters.get("rolac_controller", {})
    demands = [(b, axis) for b in pairs for axis in "xy"]
    low, high = (
        [
            values[name]
            for b, axis in demands
            for name in (f"{b}.{of_pid}_{axis}", f"{b}.i_{axis}.{of_linear}")
            if name in values and abs(values[name]) < NO_LIMIT
        ]
        for of_pid, of_linear in (("i_min", "lower"), ("i_max", "upper"))
    )
    is_late = is_on(values.get("chain.preset", IDEAL), values.get("chain.delay", 0.0))
    return (max(low), min(high)) if low and high else None, is_late


def _ratio(k_p, k_d, roll_off, shelf, zeta, d):
    """Return numerator and denominator of (1), with its minus."""
    omega_r, omega = 2.0 * np.pi * roll_off, 2.0 * np.pi * shelf
    top = np.polymul([k_d + k_p / omega_r, k_p], [1.0, 2.0 * d * zeta * omega, omega**2])
    return -top, np.polymul([1.0 / omega_r, 1.0], [1.0, 2.0 * zeta * omega, omega**2])


def _law(ratios):
    """Return A, B, C, D of the sampled law with a ratio for each axis."""
    return [block_diag(*matrices) for matrices in zip(*(tf2ss(*ratio) for ratio in ratios), strict=True)]


def _of_noise(top, bottom):
    """Return the standard deviation of a sampled law's demand under white noise of standard deviation 1."""
    impulse = np.zeros(2000)
    impulse[0] = 1.0
    return float(np.linalg.norm(lfilter(top, bottom, impulse)))


def _poles(plant, law, step):
    """Return s = ln(z)/T of the closed loop, u = K y; poles at z = 0 are left out."""
    A, B, C, _ = plant
    a, b, c, d = law
    z = np.linalg.eigvals(np.block([[A + B @ d @ C, B @ c], [b @ C, a]]))
    return np.log(z[np.abs(z) > 1e-6]) / step


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", help="of the machine at rest in its bearings: a file, or the name of one of a pack")
    parser.add_argument("--speeds", required=True, help='least, largest or trip speed: "9000 rpm, 17600 rpm"')
    parser.add_argument("--pairs", required=True, help="bearing=sensor plane, separated by commas")
    parser.add_argument("--sample-time", help="default: that of the scenario's controller")
    parser.add_argument("--noise", default="0.4 um", help="of a sensor, rms")
    parser.add_argument("--most-noise", default="0.35 A", help="in a demand, rms")
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1, help="another one may find better")
    parser.add_argument("-o", "--output", type=Path, help="default: found.toml beside the scenario file")
    given = parser.parse_args()
    pairs = dict(pair.strip().split("=") for pair in given.pairs.split(","))
    speeds = [speed.strip() for speed in given.speeds.split(",")]
    step = quantity(given.sample_time, "s", "sample-time") if given.sample_time else None
    noise = quantity(given.noise, "m", "noise"), quantity(given.most_noise, "A", "most-noise")
    search = Search(given.scenario, speeds, pairs, step, *noise)
    coefficients, cost = search.best(given.generations, given.seed)
    output = given.output or _beside(given.scenario)
    output.write_text(search.text(coefficients), encoding="utf-8")
    print(f"{output}: {cost:.3g} from what is wanted")


def _beside(scenario):
    """Return the path of found.toml beside a scenario file, or in the current folder for a scenario of a pack."""
    return (Path(scenario).parent if Path(scenario).is_file() else Path()) / "found.toml"


if __name__ == "__main__":
    main()
