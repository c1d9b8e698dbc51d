"""The expander: a machine unlike all others here, on which features of the host are tested.

Two magnetic bearings and a passive one between them, sensors and retainers away from the bearings, a seal and a turbine
that can touch, other names, a tenth of the usual clearances, 20 kHz sampling.
"""

from pathlib import Path

FOLDER = Path(__file__).parents[1] / "strange_machine"
ROTOR = FOLDER / "expander.toml"
SYSTEM = FOLDER / "levitated_expander.toml"
LEVITATION, TOUCHDOWN, RUB = (FOLDER / f"{name}.toml" for name in ("levitation", "touchdown", "rub"))

# Its rotor file for the design of magnets in every bearing: what has none is a seal.
DRAWING = ROTOR.read_text(encoding="utf-8").replace('[[bearings]]\nname = "guide"', '[[seals]]\nname = "guide"')
