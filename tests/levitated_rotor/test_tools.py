"""The assembled FMU in tools: the command line, system files, the README's code."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from assembled_rotor import T
from click.testing import CliRunner
from code_blocks import example_of
from fmpy.validation import validate_fmu

SYSTEM = """
[[component]]
name = "rig"
fmu = "{fmu}"

[[signal]]
name = "Omega"
targets = ["rig.Omega"]

[experiment]
communication_step = "1 ms"
stop_time = "0.3 s"
inputs = {{ "Omega" = "260 rad/s", "rig.rotor_contact.d1.u" = "0.5 g.m" }}

[[experiment.event]]
time = "0.12 s"
set = {{ "rig.rotor_contact.d1.u" = "25.5 g.m" }}
"""


def test_a_system_file_runs_the_assembled_fmu_alone(assembled: Callable[..., Path], tmp_path: Path) -> None:
    from amb_cosim import simulate

    shutil.copy(assembled("fig4_9"), tmp_path)
    file = tmp_path / "rig.toml"
    file.write_text(SYSTEM.format(fmu="levitated_rotor.fmu"), encoding="utf-8")
    run = simulate(file)
    assert run.outcome.status == "completed"
    force = run.dataset["rig.rotor_contact.rb1.f_n"].values
    contact = run.dataset["rig.rotor_contact.contact_state"].values
    assert contact[:120].max() == 0
    assert contact[120:].max() > 0
    assert force.max() > 100.0


@pytest.mark.slow
def test_the_command_line_builds_the_assembled_fmu(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Flavour python needs no compiler; the options are those of a build of three FMUs."""
    from amb_cosim.commands.cli import main

    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    for arguments, name in (("--assembled fig5_6", "a"), ("--assembled", "b"), ("--assembled --rotor compressor", "c")):
        done = runner.invoke(main, ["build", *arguments.split(), "--flavour", "python", "-o", name])
        assert done.exit_code == 0, done.output
        assert done.output.split() == [f"{name}/levitated_rotor.fmu"]
        assert validate_fmu(f"{name}/levitated_rotor.fmu") == []
    refused = runner.invoke(main, ["build", "--assembled", "fig4_99", "-o", "d"])
    assert refused.exit_code == 2
    assert "fig4_99" in refused.output
    assert not Path("d").exists()


@pytest.mark.slow
def test_fmi_3_gives_the_same_results(assembled: Callable[..., Path], tmp_path: Path) -> None:
    """Through contact, in FMPy; arrays of FMI 3.0 have the elements that are scalars in FMI 2.0."""
    import numpy as np
    from fmpy import read_model_description, simulate_fmu

    from amb_cosim import build_assembled

    build_assembled(tmp_path, "fig4_9", fmi=3)
    fmu = tmp_path / "levitated_rotor.fmu"
    assert validate_fmu(str(fmu)) == []
    described = read_model_description(fmu)
    assert described.fmiVersion == "3.0"
    outputs = [v for v in described.modelVariables if v.causality == "output"]
    arrays = {v.name for v in outputs if v.dimensions}
    assert arrays == {"rotor_contact.sensors", "rolac_controller.receptance"}

    def run(file: Path, names: list[str]) -> np.ndarray:
        start = {"rotor_contact.d1.u": 25.5e-3}
        return simulate_fmu(str(file), stop_time=0.1, step_size=T, output_interval=T, output=names, start_values=start)

    sensors = [f"rotor_contact.s{k}" for k in range(1, 9)]
    single = [v.name for v in outputs if not v.dimensions]
    old, new = run(assembled("fig4_9"), single + sensors), run(fmu, [*single, "rotor_contact.sensors"])
    assert new["rotor_contact.contact_state"].max() > 0
    assert [n for n in single if not np.array_equal(old[n], new[n])] == []
    assert np.array_equal(np.stack([old[n] for n in sensors], axis=-1), new["rotor_contact.sensors"])


def test_the_code_of_the_readme_runs(
    assembled: Callable[..., Path], run_python: Callable[..., Any], tmp_path: Path
) -> None:
    shutil.copy(assembled("fig4_9"), tmp_path)
    code = example_of("levitated_rotor")
    largest, force = run_python(f"{code}\nresult = [float(np.abs(run[n]).max()) for n in names]", cwd=tmp_path)
    assert largest < 0.8e-3
    assert 100.0 < force < 1e5
