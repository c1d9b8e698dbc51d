"""An FMU that shows what its host tells it: start, stop, steps, inputs; see `informed.c`."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

SOURCE = Path(__file__).parent / "informed.c"
OUTPUTS = ("y", "reached", "start", "stop", "step", "instances", "used", "tolerance")
VARIABLES = [
    ("u", 'causality="input"', 'start="0"'),
    ("k", 'causality="parameter" variability="fixed"', 'start="1"'),
    ("y0", 'causality="parameter" variability="fixed"', 'start="0"'),
    *((name, 'causality="output"', "") for name in OUTPUTS),
]
FIRST_OUTPUT = len(VARIABLES) - len(OUTPUTS)


def informed_fmu(
    fmu_from_c: Callable[..., Path], folder: Path, version: int = 2, experiment: str = "", **flags: str
) -> Path:
    """Return the FMU as a file of `folder`, with attributes of its default experiment and flags of `CoSimulation`."""
    fmu = fmu_from_c(SOURCE, description(version), version)
    copy = folder / f"Informed{version}.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(copy, "w") as new:
        for name in old.namelist():
            content = description(version, experiment, **flags) if name == "modelDescription.xml" else old.read(name)
            new.writestr(zipfile.ZipInfo(name), content)  # the same bytes at any time
    return copy


def description(version: int, experiment: str = "", **flags: str) -> str:
    """Return the modelDescription; the FMU takes any step and saves its state unless flags say otherwise."""
    state = "FMUState" if version == 3 else "FMUstate"
    abilities = ("canHandleVariableCommunicationStepSize", f"canGetAndSet{state}", f"canSerialize{state}")
    ability = dict.fromkeys(abilities, "true") | flags
    text = " ".join(f'{flag}="{value}"' for flag, value in ability.items())
    declared, listed = [], []
    for k, (name, kind, start) in enumerate(VARIABLES):
        common = f'name="{name}" valueReference="{k}" {kind}'
        if version == 3:
            declared.append(f"<Float64 {common} {start}/>")
            listed.append(f'<Output valueReference="{k}"/>')
        else:
            declared.append(f"<ScalarVariable {common}><Real {start}/></ScalarVariable>")
            listed.append(f'<Unknown index="{k + 1}"/>')
    if version == 3:
        declared.append(f'<Float64 name="time" valueReference="{len(VARIABLES)}" causality="independent"/>')
    outputs = "".join(listed[FIRST_OUTPUT:])
    head = 'fmiVersion="3.0" instantiationToken="{a}"' if version == 3 else 'fmiVersion="2.0" guid="{a}"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription {head} modelName="Informed">
<CoSimulation modelIdentifier="informed" {text}/>
{f"<DefaultExperiment {experiment}/>" if experiment else ""}
<ModelVariables>{"".join(declared)}</ModelVariables>
<ModelStructure>{outputs if version == 3 else f"<Outputs>{outputs}</Outputs>"}</ModelStructure>
</fmiModelDescription>
"""
