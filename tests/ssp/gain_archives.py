"""Archives of FMUs whose output is k times their input, with units of their own."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

SOURCE = Path(__file__).parent / "gain.c"
NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
)
DEFINED = {
    "m": '<{0} name="m"><{1}BaseUnit m="1"/></{0}>',
    "mm": '<{0} name="mm"><{1}BaseUnit m="1" factor="0.001"/></{0}>',
    "degC": '<{0} name="degC"><{1}BaseUnit K="1" offset="273.15"/></{0}>',
    "degF": '<{0} name="degF"><{1}BaseUnit K="1" factor="0.5555555555555556" offset="255.3722222222222"/></{0}>',
    "N": '<{0} name="N"><{1}BaseUnit kg="1" m="1" s="-2"/></{0}>',
    "count": '<{0} name="count"/>',
    "furlong": '<{0} name="furlong"><{1}BaseUnit m="1" factor="201.168"/></{0}>',
}


def description(unit: str | None = None) -> str:
    """Return the description of the FMU; input and output have the unit."""
    of_unit = f'unit="{unit}"' if unit else ""
    units = f"<UnitDefinitions>{DEFINED[unit].format('Unit', '')}</UnitDefinitions>" if unit in DEFINED else ""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Gain" guid="{{gain}}">
<CoSimulation modelIdentifier="gain" canHandleVariableCommunicationStepSize="true"/>{units}
<DefaultExperiment stepSize="0.1"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1" {of_unit}/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real {of_unit}/></ScalarVariable>
<ScalarVariable name="k" valueReference="2" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies="1"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def write_fmu(path: Path, compiled: Path, unit: str | None = None) -> Path:
    """Write the FMU with another unit, from the compiled one."""
    with zipfile.ZipFile(compiled) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            content = description(unit).encode() if name == "modelDescription.xml" else source.read(name)
            target.writestr(name, content)
    return path


def connector(name: str, kind: str, unit: str = "") -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{f" unit={unit!r}" if unit else ""}/></ssd:Connector>'


def gain(name: str, fmu: str = "Plain", bindings: str = "") -> str:
    """Return a component with the FMU `fmu`."""
    ends = connector("u", "input") + connector("y", "output") + connector("k", "parameter")
    source = f'source="resources/{fmu}.fmu"'
    return f'<ssd:Component name="{name}" {source}><ssd:Connectors>{ends}</ssd:Connectors>{bindings}</ssd:Component>'


def connect(start: str, end: str, inner: str = "", attributes: str = "") -> str:
    """Return a connection of two `element.connector`; those of the system itself have no element."""
    ends = ""
    for side, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition(".")
        ends += f'{side}Element="{element}" ' if element else ""
        ends += f'{side}Connector="{name}" '
    return f"<ssd:Connection {ends}{attributes}>{inner}</ssd:Connection>"


def bind(values: Mapping[str, float | str], mapping: str = "", attributes: str = "") -> str:
    """Return a binding of values, each a number or the text of an element."""
    named = "".join(
        f'<ssv:Parameter name="{name}">{v if isinstance(v, str) else f"<ssv:Real value={str(v)!r}/>"}</ssv:Parameter>'
        for name, v in values.items()
    )
    inner = f'<ssv:ParameterSet version="1.0" name="set"><ssv:Parameters>{named}</ssv:Parameters></ssv:ParameterSet>'
    mapped = (
        f'<ssd:ParameterMapping><ssm:ParameterMapping version="1.0">{mapping}</ssm:ParameterMapping>'
        "</ssd:ParameterMapping>"
        if mapping
        else ""
    )
    return (
        f"<ssd:ParameterBindings><ssd:ParameterBinding {attributes}><ssd:ParameterValues>{inner}</ssd:ParameterValues>"
        f"{mapped}</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def system(
    name: str, connectors: str = "", elements: str = "", connections: str = "", bindings: str = "", more: str = ""
) -> str:
    """Return a system; `more` are its signal dictionaries."""
    parts = (("Connectors", connectors), ("", bindings), ("Elements", elements), ("Connections", connections))
    inner = "".join(f"<ssd:{tag}>{part}</ssd:{tag}>" if tag else part for tag, part in parts if part)
    return f'<ssd:System name="{name}">{inner}{more}</ssd:System>'


def structure(root: str, units: tuple[str, ...] = ()) -> str:
    defined = "".join(DEFINED[unit].format("ssc:Unit", "ssc:") for unit in units)
    listed = f"<ssd:Units>{defined}</ssd:Units>" if defined else ""
    return (
        f'<ssd:SystemStructureDescription {NAMESPACES} version="1.0" name="gains">{root}{listed}'
        '<ssd:DefaultExperiment startTime="0" stopTime="0.5"/></ssd:SystemStructureDescription>'
    )
