"""Random plants, and controllers on them."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from controller_bench import SAMPLES, Bench, Complex, Plant, synchronous
from rig import pack


@pytest.fixture
def bench() -> type[Bench]:
    """Makes an initialised controller; parameters by name with `__` for the dot."""
    return Bench


@pytest.fixture
def discrete_plant() -> Callable[..., Plant]:
    """Makes a random stable plant with receptances of the size of the rig's; it forgets in about 20 samples."""

    def make(seed: int = 5) -> Plant:
        rng = np.random.default_rng(seed)
        a = np.zeros((12, 12))
        for k in range(6):
            radius, angle = rng.uniform(0.4, 0.8), rng.uniform(0.1, 2.5)
            block = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
            a[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = radius * np.array(block)
        return Plant(a, rng.normal(size=(12, 4)), 3e-7 * rng.normal(size=(8, 12)))

    return make


@pytest.fixture
def speed_of() -> Callable[[float], float]:
    """Return the speed (rad/s) at which a revolution has that many samples at 4 kHz."""
    return lambda samples: 2.0 * math.pi / (samples * 250e-6)


@pytest.fixture
def unbalance_response() -> Complex:
    """Synchronous displacements Q_0 (m) that an unbalance causes at the sensors of the plant Q = Q_0 + R U."""
    return 1e-4 * np.exp(1j * np.linspace(0.0, 5.0, 8)) * np.linspace(0.5, 1.5, 8)


@pytest.fixture
def optimum(receptance: Complex, unbalance_response: Complex) -> Complex:
    """Return the least-squares optimum of the forces on that plant, by a solver without H."""
    return np.linalg.lstsq(receptance, -unbalance_response, rcond=None)[0]


@pytest.fixture
def responding(
    receptance: Complex, speed_of: Callable[[float], float], unbalance_response: Complex
) -> Callable[..., tuple[Bench, Callable[..., Complex]]]:
    """Makes a controller on the plant q = Re[(Q_0 + R U) exp(j theta)], and what runs it for so many samples.

    ROLAC is on, and has a table of the receptance given, or of that of the plant. `unbalance` is a factor of Q_0 over
    revolutions.
    """

    def make(
        table_of: Complex | None = None, samples: float = SAMPLES, **parameters: float
    ) -> tuple[Bench, Callable[..., Complex]]:
        table = pack([1.0], [receptance if table_of is None else table_of])
        b = Bench(table, Omega=speed_of(samples), **{"rolac_enable": 1.0, **parameters})

        def run(count: int, unbalance: Callable[[float], float] = lambda n: 1.0) -> Complex:
            for n in range(count):
                q = unbalance(n / samples) * unbalance_response + receptance @ b.forces()
                b.sense((q * np.exp(1j * b.theta)).real)
                b.sample()
            return b.forces()

        return b, run

    return make


@pytest.fixture
def adapting(receptance: Complex, speed_of: Callable[[float], float]) -> Callable[..., Bench]:
    """Make a controller whose ROLAC has adapted for some revolutions to a vibration independent of its force."""

    def make(revolutions: int = 3, **parameters: float) -> Bench:
        b = Bench(pack([1.0], [receptance]), Omega=speed_of(SAMPLES), rolac_enable=1.0, **parameters)
        b.follow(synchronous, revolutions * SAMPLES)
        return b

    return make
