"""Fault codes of an assembly, and their sentences: those of its parts, and values between parts that are not allowed.

  1 to  99  the assembly's own
100 to 399  100 + code of a fault of the controller, 200 + of the actuator, 300 + of the plant
400 to 997  an input of a part that an output feeds, or that follows the speed, is outside its range
"""

from __future__ import annotations

from fmi_export.variables import Variable
from levitated_rotor.assembly import Assembly, Part
from levitated_rotor.interface import renamed

FAULT_LOOP = 1
OF_PART = 100
FIRST_INPUT, MOST_INPUTS = 400, 598


def input_codes(assembly: Assembly) -> dict[str, int]:
    """Return the fault codes of the inputs of parts whose values come from within the assembly, by name.

    Raises
    ------
    ValueError
        If there are more than codes.
    """
    within = {*assembly.connections, *assembly.speed_inputs}
    names = [name for name in assembly.part_inputs if name in within]
    if len(names) > MOST_INPUTS:
        raise ValueError(f"{len(names)} connected inputs is not allowed; there must be at most {MOST_INPUTS}")
    return {name: FIRST_INPUT + k for k, name in enumerate(names)}


def fault_sentences(assembly: Assembly) -> dict[int, str]:
    """Return the sentence of each fault code; it begins with the name of the component."""
    sentences = {
        FAULT_LOOP: "outputs do not settle during initialisation; the connections close an algebraic loop",
    }
    for k, part in enumerate(assembly.parts, 1):
        for code, sentence in part.model.faults.items():
            sentences[OF_PART * k + code] = f"{part.name}: {renamed(assembly, part, sentence)}"
    codes = input_codes(assembly)
    for part in assembly.parts:
        for name, v in part.of("input"):
            if name in codes:
                sentences[codes[name]] = f"{part.name}: {_outside(assembly, part, v)}"
    return sentences


def _outside(assembly: Assembly, part: Part, v: Variable) -> str:
    allowed = v.describe_range(0.0).removeprefix(f"{v.name} = 0")
    return f"{v.name} = {{{assembly.named(part, v.name)}}}{allowed}"
