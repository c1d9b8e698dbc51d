"""Experiments with reference results, which are stored in FMUs for checking importers.

The files are placed as FMI-LS-REF 1.0.0-alpha.1 specifies (github.com/modelica/fmi-ls-ref), and have the Modelica
Association's format for experiments (github.com/modelica/ma-hs-experiments):

    extra/org.fmi-standard.fmi-ls-ref/
      fmi-ls-manifest.xml    an experiment/smoke-test
      smoke_test.exp         step size and stop time, and the names of both tables
      stimuli.csv            inputs, each constant
      references.csv         all outputs at the start and after each step, with all digits

The experiment consists of ten steps of the usual size that begin at the start values. Inputs with a nominal size
(displacements, currents and forces) are set to different values, which are a few per cent of that size. FMPy computes
the results with the engine for the platform on which the FMU is built. With other C libraries, results differ in the
last bits.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement, register_namespace

from amb_files.temporary_folders import temporary_folder
from fmi_export.building.arrays import slots
from fmi_export.building.description import model_description, xml_file
from fmi_export.building.native.compiler import PLATFORMS, host_platform
from fmi_export.building.native.data import model_data
from fmi_export.building.native.engines import Engine, engine_at_hand, engine_key
from fmi_export.building.units import NOMINAL
from fmi_export.interface import Interface
from fmi_export.model import Array, Model
from fmi_export.variables import Variable

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
STANDARD = {  # of the manifest, in this namespace
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
EXPERIMENTS = "application/x-ma-hs-experiments"  # type of the file
STEPS = 10
SHARE = 0.02  # smallest stimulus, relative to the nominal size
TEXT = """This FMU contains an experiment with reference results (FMI-LS-REF, extra/org.fmi-standard.fmi-ls-ref).
The experiment takes {steps} steps of {h!r} s from the start values, with the inputs of stimuli.csv if this file exists.
The outputs are in references.csv.
A tool that runs the FMU correctly obtains these values, except for the last bits if it uses a different C library.
`amb-cosim verify {name}.fmu` runs the experiment in FMPy and compares the results.
"""

Columns = dict[str, list[Any]]


def experiment_files(model: Model, constants: Array, by_slot: bool = False) -> dict[str, bytes]:
    """Return the files of the experiment by their paths in an FMU.

    If there is no shipped or cached engine for this machine, no files are returned, because an engine is not compiled
    just for the experiment. No files are returned either if the model cannot take these steps.

    Parameters
    ----------
    by_slot
        Whether the FMU has the arrays of FMI 3.0; each array is then one column, with values separated by blanks.
    """
    try:
        engine = engine_at_hand(model.compiled, host_platform())
    except ValueError:  # a machine without platform
        return {}
    stimuli = stimuli_of(model.interface)
    for values in (stimuli, {}):
        result = None if engine is None else _simulated(model, constants, engine, values)
        if result is not None:
            return _files(model, values, result, by_slot)
    return {}


def stimuli_of(table: Interface) -> dict[str, float]:
    """Return a small value for each Real input whose unit has a nominal size."""
    inputs = [v for v in table.of("input") if v.type == "Real" and v.unit in NOMINAL]
    sizes = ((-1) ** k * (1 + k % 5) * SHARE * NOMINAL[v.unit] for k, v in enumerate(inputs))
    return {v.name: min(max(size, v.minimum), v.maximum) for v, size in zip(inputs, sizes, strict=True)}


def _simulated(model: Model, constants: Array, engine: Engine, start: Mapping[str, float]) -> Columns | None:
    """Return the time and the outputs from a run in FMPy, or None if the model cannot take these steps."""
    from fmpy import simulate_fmu
    from fmpy.fmi1 import FMICallException

    platform, token = host_platform(), "{experiment}"
    with temporary_folder() as folder:
        library = folder / "binaries" / platform / f"{model.name}{PLATFORMS[platform][0]}"
        library.parent.mkdir(parents=True)
        library.write_bytes(engine.library)
        (folder / "resources").mkdir()
        data = model_data(model, constants, token, engine_key(model.compiled))
        (folder / "resources" / "model.bin").write_bytes(data)
        (folder / "modelDescription.xml").write_bytes(xml_file(model_description(model, token, "", "", False)))
        names = [v.name for v in model.interface.of("output")]
        try:
            result = simulate_fmu(
                str(folder),
                validate=False,
                stop_time=STEPS * model.step_size,
                output_interval=model.step_size,
                start_values=dict(start),
                output=names,
                logger=lambda *_: None,
            )
        except FMICallException:
            return None
    return {name: result[name].tolist() for name in ("time", *names)}


def _files(model: Model, stimuli: Mapping[str, float], results: Columns, by_slot: bool) -> dict[str, bytes]:
    outputs, inputs = model.interface.of("output"), [v for v in model.interface.of("input") if v.name in stimuli]
    times = [results["time"][0], results["time"][-1]]
    tables = {"references": _table(model, outputs, results, by_slot)}
    if inputs:
        values: Columns = {"time": times} | {name: [value] * 2 for name, value in stimuli.items()}
        tables["stimuli"] = _table(model, inputs, values, by_slot)
    files = {f"{name}.csv": table for name, table in tables.items()}
    files["fmi-ls-manifest.xml"], files["smoke_test.exp"] = _manifest(), _experiments(model, bool(inputs))
    text = TEXT.format(steps=STEPS, h=model.step_size, name=model.name)
    return {f"{FOLDER}/{name}": file for name, file in files.items()} | {"documentation/fmi-ls-ref.txt": text.encode()}


def _manifest() -> bytes:
    register_namespace("fmi-ls", NAMESPACE)
    root = Element("fmiReferences", {f"{{{NAMESPACE}}}{name}": value for name, value in STANDARD.items()})
    role, description = "experiment/smoke-test", "Short run from the start values, with reference results"
    SubElement(root, "Related", type=EXPERIMENTS, source="smoke_test.exp", role=role, description=description)
    return xml_file(root)


def _experiments(model: Model, has_stimuli: bool) -> bytes:
    root = Element("Experiments", name="Smoke tests", description=f"{model.name} from its start values")
    item = SubElement(root, "Experiment", name="smoke_test", description="Constant inputs from the start values")
    stop, h = repr(STEPS * model.step_size), repr(model.step_size)
    SubElement(item, "TransientSimulation", startTime="0", stopTime=stop, stepSize=h)
    if has_stimuli:
        SubElement(item, "Stimuli", source="stimuli.csv", type="text/csv")
    SubElement(item, "References", source="references.csv", type="text/csv")
    return xml_file(root)


def _table(model: Model, variables: Sequence[Variable], values: Columns, by_slot: bool) -> bytes:
    """Return a table of time and variables; if `by_slot` is true, an array is a single column."""
    names = {v.name for v in variables}
    groups = {v.name: [v.name] for v in variables}
    if by_slot:
        arrays = [(slot.name, [v.name for v in slot.variables]) for slot in slots(model.interface)]
        groups = {name: members for name, members in arrays if names.issuperset(members)}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *groups])
    for n, time in enumerate(values["time"]):
        row = [" ".join(_text(values[name][n]) for name in members) for members in groups.values()]
        writer.writerow([_text(time), *row])
    return text.getvalue().encode()


def _text(value: float | bool) -> str:
    return repr(int(value) if isinstance(value, bool) else value)
