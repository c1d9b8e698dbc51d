"""FMUs compiled from a file of C by ziglang, for Linux on this processor."""

import platform
import subprocess
import sys
import zipfile
from collections.abc import Iterable
from pathlib import Path

import pytest

DEFAULTS = Path(__file__).parent / "defaults.c"
PLATFORMS = {2: "linux64", 3: f"{platform.machine().lower()}-linux"}
INPUT, OUTPUT, PARAMETER = 'causality="input"', 'causality="output"', 'causality="parameter" variability="fixed"'
ANY_STEP = 'canHandleVariableCommunicationStepSize="true"'


def described(
    model: str, variables: Iterable[tuple[str, str, str]], version: int = 2, abilities: str = ANY_STEP, more: str = "",
    structure: str = "",
) -> str:  # fmt: skip
    """Return the modelDescription of an FMU compiled from `model.c`.

    Variables are name, causality, and type with its start value as FMI 2.0 has them; references are their positions.
    `more` goes before the variables, `structure` behind the outputs.
    """
    declared, outputs = [], []
    for k, (name, role, kind) in enumerate(variables):
        common = f'name="{name}" valueReference="{k}" {role}'
        word, _, start = kind.partition(" ")
        declared.append({
            2: f"<ScalarVariable {common}><{kind}/></ScalarVariable>",
            3: f"<{'Float64' if word == 'Real' else word} {common} {start}/>",
        }[version])  # fmt: skip
        if OUTPUT in role:
            outputs.append({2: f'<Unknown index="{k + 1}"/>', 3: f'<Output valueReference="{k}"/>'}[version])
    head, listed = f'fmiVersion="2.0" guid="{{{model}}}"', f"<Outputs>{''.join(outputs)}</Outputs>"
    if version == 3:
        declared.append(f'<Float64 name="time" valueReference="{len(declared)}" causality="independent"/>')
        head, listed = f'fmiVersion="3.0" instantiationToken="{{{model}}}"', "".join(outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription {head} modelName="{model}">
<CoSimulation modelIdentifier="{model.lower()}" {abilities}/>{more}
<ModelVariables>{"".join(declared)}</ModelVariables>
<ModelStructure>{listed}{structure}</ModelStructure>
</fmiModelDescription>
"""


def compile_fmu(folder: Path, source: Path, description: str, version: int = 2) -> None:
    """Write `Name.fmu` of `name.c`, and functions of `defaults.c` that it lacks; C has the version as FMI_VERSION."""
    if sys.platform != "linux":
        pytest.skip("the FMU is compiled for Linux")
    pytest.importorskip("ziglang", reason="the FMU is compiled by ziglang: pip install 'amb-cosim[native]'")
    library = folder / f"{source.stem}.so"
    options = ["-shared", "-fPIC", "-O2", "-ffp-contract=off", "-fno-sanitize=all", f"-DFMI_VERSION={version}"]
    command = [sys.executable, "-m", "ziglang", "cc", *options, "-o", library, source, DEFAULTS]
    subprocess.run(command, check=True, capture_output=True)
    with zipfile.ZipFile(folder / f"{source.stem.capitalize()}.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{PLATFORMS[version]}/{library.name}")
