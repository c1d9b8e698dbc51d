"""Variable table of an assembly: those of its parts, without the inputs that an output feeds."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from fmi_export.interface import Interface
from fmi_export.model import STEP_SIZE
from fmi_export.variables import FAULT_CODE, Array, Variable, output
from levitated_rotor.assembly import Assembly, Part


def interface_of(assembly: Assembly) -> Interface:
    """Return parameters of all parts, inputs of the assembly, outputs of all parts, and the fault code."""
    return Interface((*_parameters(assembly), *_inputs(assembly), *_outputs(assembly), FAULT))


Needs = dict[str, set[str] | None]  # variables of the assembly that an output needs, by its name

FAULT = output(FAULT_CODE, "1", "0 while all is well; the log says what else means", type="Integer", starts_from=())


def renamed(assembly: Assembly, part: Part, sentence: str) -> str:
    """Return a sentence of a part in which `{name}` names variables of the assembly."""
    return re.sub(
        r"\{([^}]+)\}",
        lambda match: match[0] if match[1] == STEP_SIZE else f"{{{assembly.named(part, match[1])}}}",
        sentence,
    )


def _array(assembly: Assembly, part: Part, v: Variable) -> Array | None:
    return v.array and v.array._replace(name=assembly.named(part, v.array.name))


def _parameters(assembly: Assembly) -> Iterator[Variable]:
    for part in assembly.parts:
        for name, v in part.of("parameter"):
            array = _array(assembly, part, v)
            yield replace(v, name=name, field="", array=array)


def _inputs(assembly: Assembly) -> Iterator[Variable]:
    for name, targets in assembly.inputs.items():
        first, *others = (assembly.part_inputs[target] for target in targets)
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


def _outputs(assembly: Assembly) -> Iterator[Variable]:
    reached, started = _closed(assembly, _reaching(assembly)), _closed(assembly, _starting(assembly))
    for part in assembly.parts:
        for name, v in part.of("output"):
            same = assembly.named(part, v.starts_as) if v.starts_as else ""
            yield replace(
                v,
                name=name,
                field="",
                depends_on=reached[name] or (),
                starts_from=started[name],
                starts_as="" if same in assembly.outputs else same,
                warning=renamed(assembly, part, v.warning),
                array=_array(assembly, part, v),
            )


def _reaching(assembly: Assembly) -> Needs:
    """Return what reaches each output without delay."""
    return {
        name: {assembly.named(part, u) for u in v.depends_on}
        for part in assembly.parts
        for name, v in part.of("output")
    }


def _starting(assembly: Assembly) -> Needs:
    """Return what each output depends on at the start, None where that is not declared."""
    needs: Needs = {}
    for part in assembly.parts:
        declared = part.model.interface.initial_dependencies
        for name, v in part.of("output"):
            of_part = declared.get(v.name)
            needs[name] = None if of_part is None else {assembly.named(part, u) for u in of_part}
    return needs


def _closed(assembly: Assembly, needs: Needs) -> dict[str, tuple[str, ...] | None]:
    """Return the parameters and inputs of the assembly that the needs of each output lead to, in the table's order."""
    order = [name for part in assembly.parts for name, _ in part.of("parameter")] + list(assembly.inputs)
    found: dict[str, tuple[str, ...] | None] = {}
    for shown in needs:
        known, new = set(), {shown}
        while new:
            known |= new
            further = [needs.get(name, set()) for name in new]
            if None in further:
                break
            new = {name for names in further for name in names or ()} - known
        found[shown] = None if new else tuple(name for name in order if name in known)
    return found
