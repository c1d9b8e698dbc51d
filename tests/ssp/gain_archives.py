"""Archives of FMUs whose output is k times their input, each with its units."""

from collections.abc import Mapping
from pathlib import Path

from tests.support.c_fmus import INPUT, OUTPUT, PARAMETER, described
from tests.support.changed_archive import changed_archive

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
    """Return the description of the FMU; input and output have the unit, of a difference if ` rise` follows."""
    unit, _, rise = (unit or "").partition(" ")
    of_unit = (f'unit="{unit}"' if unit else "") + (' relativeQuantity="true"' if rise else "")
    units = f"<UnitDefinitions>{DEFINED[unit].format('Unit', '')}</UnitDefinitions>" if unit in DEFINED else ""
    variables = (("u", INPUT, f'Real start="1" {of_unit}'), ("y", OUTPUT, f"Real {of_unit}"))
    gain = "k", PARAMETER, 'Real start="1"'
    return described("Gain", (*variables, gain), more=f'{units}<DefaultExperiment stepSize="0.1"/>')


def write_fmu(path: Path, compiled: Path, unit: str | None = None) -> Path:
    """Write the FMU with another unit, from the compiled one."""
    return changed_archive(compiled, path, {"modelDescription.xml": description(unit)})


def connector(name: str, kind: str, unit: str = "") -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{f" unit={unit!r}" if unit else ""}/></ssd:Connector>'


def component(name: str, source: str, connectors: str, bindings: str = "", attributes: str = "") -> str:
    head = f'<ssd:Component name="{name}" source="{source}" {attributes}>'
    return f"{head}<ssd:Connectors>{connectors}</ssd:Connectors>{bindings}</ssd:Component>"


def gain(name: str, fmu: str = "Plain", bindings: str = "") -> str:
    """Return a component with the FMU `fmu`."""
    ends = connector("u", "input") + connector("y", "output") + connector("k", "parameter")
    return component(name, f"resources/{fmu}.fmu", ends, bindings)


def connect(start: str, end: str, inner: str = "", attributes: str = "") -> str:
    """Return a connection of two `element.connector`; those of the system itself have no element."""
    ends = ""
    for side, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition(".")
        ends += f'{side}Element="{element}" ' if element else ""
        ends += f'{side}Connector="{name}" '
    return f"<ssd:Connection {ends}{attributes}>{inner}</ssd:Connection>"


def value_set(values: Mapping[str, float | str]) -> str:
    """Return a document of values, each a number or the text of an element."""
    named = "".join(
        f'<ssv:Parameter name="{name}">{v if isinstance(v, str) else f"<ssv:Real value={str(v)!r}/>"}</ssv:Parameter>'
        for name, v in values.items()
    )
    parameters = f"<ssv:Parameters>{named}</ssv:Parameters>"
    return f'<ssv:ParameterSet {NAMESPACES} version="1.0" name="set">{parameters}</ssv:ParameterSet>'


def binding(inner: str, attributes: str = "") -> str:
    """Return the only binding of a system or a component."""
    bound = f"<ssd:ParameterBinding {attributes}>{inner}</ssd:ParameterBinding>"
    return f"<ssd:ParameterBindings>{bound}</ssd:ParameterBindings>"


def bind(values: Mapping[str, float | str], mapping: str = "", attributes: str = "") -> str:
    """Return a binding of values, and their mapping."""
    inner = f"<ssd:ParameterValues>{value_set(values)}</ssd:ParameterValues>"
    if mapping:
        mapping = f'<ssm:ParameterMapping version="1.0">{mapping}</ssm:ParameterMapping>'
        inner += f"<ssd:ParameterMapping>{mapping}</ssd:ParameterMapping>"
    return binding(inner, attributes)


def system(
    name: str, connectors: str = "", elements: str = "", connections: str = "", bindings: str = "", more: str = ""
) -> str:
    """Return a system; `more` are its signal dictionaries."""
    parts = (("Connectors", connectors), ("", bindings), ("Elements", elements), ("Connections", connections))
    inner = "".join(f"<ssd:{tag}>{part}</ssd:{tag}>" if tag else part for tag, part in parts if part)
    return f'<ssd:System name="{name}">{inner}{more}</ssd:System>'


EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="0.5"/>'


def structure(root: str, units: tuple[str, ...] = (), experiment: str = EXPERIMENT) -> str:
    defined = "".join(DEFINED[unit].format("ssc:Unit", "ssc:") for unit in units)
    listed = f"<ssd:Units>{defined}</ssd:Units>" if defined else ""
    head = f'<ssd:SystemStructureDescription {NAMESPACES} version="1.0" name="gains">'
    return f"{head}{root}{listed}{experiment}</ssd:SystemStructureDescription>"


LAW = '<ssc:LinearTransformation factor="{}" offset="{}"/>'
ENTRY = '<ssm:MappingEntry source="{}" target="{}">{}</ssm:MappingEntry>'
IN, OUT = connector("In", "input"), connector("Out", "output", "mm")
CHAIN = gain("a", "{}") + gain("b", "{}")
