"""The command line, also in a process, and FMUs that are not this project's, built once by PythonFMU or from C."""

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import PIPE

import pytest
from command_line import COMMAND

from tests.orchestrator.conftest import refuses, runner

__all__ = ["refuses", "runner"]

SUPPORT = Path(__file__).parent / "support"


@pytest.fixture(scope="session")
def foreign_fmus(create_once: Callable[..., Path]) -> Path:
    """Folder with `Mass.fmu` and `Spring.fmu`."""
    from pythonfmu.builder import FmuBuilder

    def fill(folder: Path) -> None:
        for script in SUPPORT.glob("*.py"):
            FmuBuilder.build_FMU(script, dest=folder)

    return create_once("foreign-fmus", fill)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """`start(*arguments)`: a process of the command line in an empty folder, which is ended with the test."""
    processes = []

    def begin(*arguments: object) -> subprocess.Popen[str]:
        command = [*COMMAND, *map(str, arguments)]
        processes.append(subprocess.Popen(command, cwd=tmp_path, stdout=PIPE, stderr=PIPE, text=True))
        return processes[-1]

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


KINDS3 = ("Float64", "Float32", *(f"{u}Int{n}" for n in (8, 16, 32, 64) for u in ("", "U")), "Boolean")


def description3() -> str:
    """The description of `arrays3.c`, whose arrays have two rows, and three columns by a structural parameter."""

    def variable(kind: str, name: str, reference: int, causality: str, more: str = "", inner: str = "") -> str:
        discrete = "" if kind.startswith("Float") or causality == "parameter" else 'variability="discrete"'
        attributes = f'name="{name}" valueReference="{reference}" causality="{causality}" {discrete} {more}'
        return f"<{kind} {attributes}>{inner}</{kind}>"

    pair = '<Dimension start="2"/>'
    result = []
    for k, kind in enumerate(KINDS3):
        start = 'start="false true"' if kind == "Boolean" else 'start="1 2"'
        result.append(variable(kind, f"{kind}.in", 1 + 2 * k, "input", start, pair))
        result.append(variable(kind, f"{kind}.out", 2 + 2 * k, "output", "", pair))
    result += [
        variable("Int32", "what", 100, "input", 'start="0"'),
        variable("Float64", "m", 101, "parameter", 'start="1 2 3 4 5 6"', f'{pair}<Dimension valueReference="200"/>'),
        variable("Float64", "sum", 102, "output"),
        variable("Enumeration", "choice", 103, "input", 'start="1" declaredType="Choice"'),
        variable("Enumeration", "chosen", 104, "output", 'declaredType="Choice"'),
        '<UInt64 name="columns" valueReference="200" causality="structuralParameter" variability="fixed" start="3"/>',
        '<Float64 name="time" valueReference="201" causality="independent"/>',
        '<String name="text" valueReference="202" causality="input"><Start value="a"/></String>',
        '<Clock name="tick" valueReference="203" causality="input" intervalVariability="triggered"/>',
        '<Float64 name="ticked" valueReference="204" causality="input" variability="discrete" clocks="203" start="0"/>',
    ]
    abilities = 'canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true" canSerializeFMUState="true"'
    outputs = "".join(
        f'<Output valueReference="{r}" dependencies=""/>' for r in (*range(2, 2 + 2 * len(KINDS3), 2), 102, 104)
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Arrays3" instantiationToken="{{a}}">
<CoSimulation modelIdentifier="arrays3" {abilities}/>
<TypeDefinitions><EnumerationType name="Choice"><Item name="one" value="1"/><Item name="far" value="70000"/>
</EnumerationType></TypeDefinitions>
<ModelVariables>{"".join(result)}</ModelVariables>
<ModelStructure>{outputs}</ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="session")
def arrays3_fmu(fmu_from_c: Callable[..., Path]) -> Path:
    """`Arrays3.fmu`, of FMI 3.0."""
    return fmu_from_c(SUPPORT / "arrays3.c", description3(), version=3)
