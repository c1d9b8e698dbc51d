"""Variable table of an assembly: those of its parts, without the inputs that an output feeds."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from fmi_export.model import STEP_SIZE
from fmi_export.variables import FAULT_CODE, Interface, Variable, output
from levitated_rotor.assembly import Assembly, Part


def interface_of(assembly: Assembly) -> Interface:
    """Return parameters of all parts, inputs of the assembly, outputs of all parts, and the fault code."""
    return Interface((*_parameters(assembly), *_inputs(assembly), *_outputs(assembly), FAULT))


FAULT = output(FAULT_CODE, "1", "0 while all is well; the log says what else means", type="Integer")


def renamed(assembly: Assembly, part: Part, sentence: str) -> str:
    """Return a sentence of a part in which `{name}` names variables of the assembly."""
    return re.sub(
        r"\{([^}]+)\}",
        lambda match: match[0] if match[1] == STEP_SIZE else f"{{{assembly.named(part, match[1])}}}",
        sentence,
    )


def _parameters(assembly: Assembly) -> Iterator[Variable]:
    for part in assembly.parts:
        for name, v in part.of("parameter"):
            yield replace(v, name=name, field="", start=assembly.start.get(name, v.start))


def _inputs(assembly: Assembly) -> Iterator[Variable]:
    for name, targets in assembly.inputs.items():
        first, *others = (assembly.part_inputs[target] for target in targets)
        if any((v.type, v.unit) != (first.type, first.unit) for v in others):
            raise ValueError(f"{name} feeds inputs of different types or units: {', '.join(targets)}")
        yield replace(
            first,
            name=name,
            field="",
            minimum=max(v.minimum for v in (first, *others)),
            maximum=min(v.maximum for v in (first, *others)),
            start=assembly.start.get(name, first.start),
        )


def _outputs(assembly: Assembly) -> Iterator[Variable]:
    reached = _reached_by(assembly)
    for part in assembly.parts:
        for name, v in part.of("output"):
            yield replace(
                v, name=name, field="", depends_on=tuple(reached[name]), warning=renamed(assembly, part, v.warning)
            )


def _reached_by(assembly: Assembly) -> dict[str, list[str]]:
    """Return the inputs of the assembly that reach each output without delay, in the order of the table."""
    needs = {
        name: {assembly.named(part, u) for u in v.depends_on}
        for part in assembly.parts
        for name, v in part.of("output")
    }
    reached = {name: set(sources) for name, sources in needs.items()}
    changed = True
    while changed:
        changed = False
        for sources in reached.values():
            further = set().union(*(reached.get(source, ()) for source in sources)) - sources
            sources |= further
            changed = changed or bool(further)
    order = list(assembly.inputs)
    return {name: [u for u in order if u in sources] for name, sources in reached.items()}
