"""An FMU whose outputs are the arguments of its host: start, stop, steps, inputs; see `informed.c`."""

from collections.abc import Callable
from pathlib import Path

from tests.support.c_fmus import INPUT, OUTPUT, PARAMETER, described
from tests.support.changed_archive import changed_archive

SOURCE = Path(__file__).parent / "informed.c"
OUTPUTS = ("y", "reached", "start", "stop", "step", "instances", "used", "tolerance")
VARIABLES = [
    *(("u", INPUT, 'Real start="0"'), ("k", PARAMETER, 'Real start="1"'), ("y0", PARAMETER, 'Real start="0"')),
    *((name, OUTPUT, "Real") for name in OUTPUTS),
]


def informed_fmu(
    fmu_from_c: Callable[..., Path], folder: Path, version: int = 2, experiment: str = "", **flags: str
) -> Path:
    """Return the FMU as a file of `folder`, with attributes of its default experiment and flags of `CoSimulation`."""
    fmu = fmu_from_c(SOURCE, description(version), version)
    described = description(version, experiment, **flags)
    return changed_archive(fmu, folder / f"Informed{version}.fmu", {"modelDescription.xml": described})


def description(version: int, experiment: str = "", **flags: str) -> str:
    """Return the modelDescription; the FMU takes any step and saves its state unless flags say otherwise."""
    state = "FMUState" if version == 3 else "FMUstate"
    abilities = ("canHandleVariableCommunicationStepSize", f"canGetAndSet{state}", f"canSerialize{state}")
    ability = dict.fromkeys(abilities, "true") | flags
    text = " ".join(f'{flag}="{value}"' for flag, value in ability.items())
    more = f"<DefaultExperiment {experiment}/>" if experiment else ""
    return described("Informed", VARIABLES, version, text, more)
