"""Variable table of an assembly: the variables of its parts, except inputs that are connected to an output."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from fmi_export.interface import Interface
from fmi_export.model import STEP_SIZE, AssembledModel
from fmi_export.variables import FAULT, Array, Variable
from levitated_rotor.assembly import Composite, variables


def interface_of(composite: Composite) -> Interface:
    """Return the parameters of all parts, the inputs of the assembly, the outputs of all parts, and the fault code."""
    return Interface((*_parameters(composite), *_inputs(composite), *_outputs(composite), FAULT))


Needs = dict[str, set[str] | None]  # variables of the assembly that an output needs, by its name


def renamed(composite: Composite, part: AssembledModel, sentence: str) -> str:
    """Return a sentence about a part, with each `{name}` replaced by the variable's name in the assembly."""
    return re.sub(
        r"\{([^}]+)\}",
        lambda match: match[0] if match[1] == STEP_SIZE else f"{{{composite.named(part, match[1])}}}",
        sentence,
    )


def _array(composite: Composite, part: AssembledModel, v: Variable) -> Array | None:
    return v.array and v.array._replace(name=composite.named(part, v.array.name))


def _parameters(composite: Composite) -> Iterator[Variable]:
    for part in composite.parts:
        for name, v in variables(part, "parameter"):
            array = _array(composite, part, v)
            yield replace(v, name=name, field="", array=array)


def _inputs(composite: Composite) -> Iterator[Variable]:
    for name, targets in composite.inputs.items():
        first, *others = (composite.part_inputs[target] for target in targets)
        if any((v.type, v.unit) != (first.type, first.unit) for v in others):
            raise ValueError(f"{name} feeds inputs of different types or units: {', '.join(targets)}")
        yield replace(
            first,
            name=name,
            field="",
            array=None,
            minimum=max(v.minimum for v in (first, *others)),
            maximum=min(v.maximum for v in (first, *others)),
        )


def _outputs(composite: Composite) -> Iterator[Variable]:
    direct = _traced_to_inputs(composite, _direct_dependencies(composite))
    initial = _traced_to_inputs(composite, _initial_dependencies(composite))
    for part in composite.parts:
        for name, v in variables(part, "output"):
            same = composite.named(part, v.initially_equals) if v.initially_equals else ""
            yield replace(
                v,
                name=name,
                field="",
                depends_on=direct[name] or (),
                initially_depends_on=initial[name],
                initially_equals="" if same in composite.outputs else same,
                warning=renamed(composite, part, v.warning),
                array=_array(composite, part, v),
            )


def _direct_dependencies(composite: Composite) -> Needs:
    """Return, for each output, the inputs that affect it without delay."""
    return {
        name: {composite.named(part, u) for u in v.depends_on}
        for part in composite.parts
        for name, v in variables(part, "output")
    }


def _initial_dependencies(composite: Composite) -> Needs:
    """Return the variables on which each output depends at the start, or None if they are not declared."""
    needs: Needs = {}
    for part in composite.parts:
        declared = part.model.interface.initial_dependencies
        for name, v in variables(part, "output"):
            of_part = declared.get(v.name)
            needs[name] = None if of_part is None else {composite.named(part, u) for u in of_part}
    return needs


def _traced_to_inputs(composite: Composite, needs: Needs) -> dict[str, tuple[str, ...] | None]:
    """Return, for each output, the assembly's parameters and inputs on which it depends, also through other outputs."""
    order = [name for part in composite.parts for name, _ in variables(part, "parameter")] + list(composite.inputs)
    result: dict[str, tuple[str, ...] | None] = {}
    for name in needs:
        reached, new = set(), {name}
        while new:
            reached |= new
            further = [needs.get(name, set()) for name in new]
            if None in further:
                break
            new = {name for names in further for name in names or ()} - reached
        result[name] = None if new else tuple(name for name in order if name in reached)
    return result
