"""Bad input of every command: one message, exit code 2, and nothing written."""

import json
import shlex
import sys
from pathlib import Path

import pytest
from command_line import run_command
from pump import LEVITATED, SHAFT, sensors

from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.result import Result
from rotor_analysis.packaged_rotors import rotor_path

ROSS = Path(__file__).parents[1] / "reference" / "ross"

FMU = "description = 'd'\nOmega = '100 rad/s'\nend_cycle = 1\nfmu.amb_actuator = '{}'\n"

FILES = {
    "shaft.toml": SHAFT,
    "bare.toml": LEVITATED,
    "blind.toml": LEVITATED + sensors(1, 1, 1, 1),
    "long.toml": rotor_path().read_text(encoding="utf-8").replace("node = 13", "node = 40", 1),
    "text.fmu": "not a zip",
    "text.toml": FMU.format("text.fmu"),
    "none.toml": FMU.format("none.fmu"),
    "taken": "",
}


@pytest.fixture(scope="module")
def saved(synthetic, tmp_path_factory) -> Path:
    """Folder of a saved result of 20 cycles."""
    dataset = synthetic(outcome=json.dumps(["completed", 0.4, None, ""]))
    return Result(dataset, Outcome("completed", 0.4)).save(tmp_path_factory.mktemp("saved"), plots=False)


@pytest.fixture
def folder(tmp_path: Path, saved: Path) -> Path:
    """A folder with bad files, an empty folder `empty`, and the saved result `run`."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "empty").mkdir()
    (tmp_path / "run").symlink_to(saved)
    return tmp_path


MANY = "1" * 400
CLEARANCE = "run fig4_9 --set rotor_contact.rb1.clearance="
SWEEP = "sweep fig4_9 --vary Omega=200,220rad/s"

RUN = {
    "run fig4_8": "no scenario 'fig4_8'; did you mean fig4_",
    "run mine.toml": "no file 'mine.toml' in /",
    "run none.toml": "none.fmu",
    "run text.toml": "text.fmu cannot be unpacked: it is not a zip archive",
    "run fig4_9 --set rotor.d1.u=1": "no component 'rotor'; did you mean",
    "run fig4_9 --set rotor_contact.d1.v=1": "no variable 'd1.v'; did you mean d1.",
    "run fig4_9 --set 'rotor_contact.d1.u=1 m'": "which cannot be converted to kg.m",
    f"{CLEARANCE}'-0.75 mm'": "clearance = -0.00075 m (-0.75 mm) is not allowed; it must be >= 1e-06",
    "run fig4_9 --set rotor_contact.mb1.f_x=0": "mb1.f_x cannot be set; it is connected to amb_actuator.mb1.f_x",
    "run fig4_9 --until 0": "until = 0 s is not allowed; it must be > 0 s",
    "run fig4_9 --until 1e308": "until = 1e308 is not allowed; it must be from 1e-100 to 1e+100 s",
    "run fig4_9 -o taken": "taken cannot be written to; it is a file",
    "run fig4_9 --summary-json no/s.json": "no/s.json cannot be written to",
    "run fig5_6 --receptances t.toml": "scenario fig5_6: receptances = 't.toml' is not allowed; there is no file t",
    f"{CLEARANCE}{MANY}": "rotor_contact.rb1.clearance = 1111111111",
    f"{CLEARANCE}'1 {'m.' * 3000}m'": "unknown unit 'm.m.m.m.",
    f"{CLEARANCE}'1 m**9**9**9**9'": "unknown unit 'm**9**9**9**9'",
    "run fig4_9 --set Omega=1e-99rad/s": " s is not allowed; it must be within 2.5e+08 s",
    "build -o fmus --rotor long.toml": "bodies[3].node (d4) = 40 is not allowed; it must be a node number from 1 to 13",
    "build -o fmus --flavour python --platform darwin64": "PythonFMU has no library for darwin64",
    "build -o fmus --no-arrays": "FMUs without arrays require FMI 3.0 (fmi = 3); FMI 2.0 never has arrays",
    "build -o fmus --sources --flavour python": "sources = True is not allowed with flavour = python",
    "animate results/fig4_9": "any more; use 'amb-cosim live SCENARIO'",
    "modes bath_rig": "any more; use 'amb-cosim study modes'",
    "tables": "any more; use 'amb-cosim study tables'",
}

ANALYSES = {
    "study modes --rotor nope.toml": "rotor file nope.toml cannot be read",
    "study modes --speeds '90 rad/s,fast'": "speeds = 'fast' is not a number",
    "study modes --count 0": "count = 0 is not allowed; it must be 1 or more",
    "study campbell --up-to 0": "up-to = 0 rpm is not allowed; it must be > 0 rpm",
    "study tables --planes 1,x": "planes = 1,x is not allowed; it must be node",
    "study unbalance_response --node 99": "node = 99 is not allowed; it must be a node",
    "study unbalance_response --place fan": "place = fan is not allowed; ",
    "study unbalance_response fig4_9 --mass diagonal": "mass = diagonal is not allowed with a scenario",
    "study response --channel 1.x=left.x --channel 1.x=right.x": "1.x=right.x is not allowed with 1.x=left.x",
    "study unbalance_response --rotor shaft.toml": "node is missing: a rotor without disc planes",
    "rotor import missing.toml": "ROSS file missing.toml cannot be read: No such file or directory",
    f"rotor import {rotor_path()}": "it must be a rotor saved by ROSS as TOML",
    f"rotor import {ROSS}/cone.toml -o away/cone.toml": "there is no folder away",
    **{
        f"study {study} --up-to {speed}": "up-to = "
        for study in ("campbell", "h_matrix")
        for speed in ("1e308Hz", "1e15Hz")
    },
}

CONTROL = {
    "study linearisation --bias-current 0": "bias-current = 0 A is not allowed; it must be > 0 A",
    "study linearisation --static-current '9 A'": "bias-current = 4.43 A plus static-current = 9 A is not allowed",
    "study sensitivity --sample-time '1 ms'": "the loop is not stable: a vibration of",
    "study sensitivity --set rolac_controller.*.c_d_?=1": "rolac_controller has no parameter or input '*.c_d_?'",
    "study sensitivity --set 'rotor_contact.d1.u=1 g.m'": "d1.u cannot be set here; only parameters can",
    "study receptance --up-to '1 Hz'": "up-to = 60 rpm (1 Hz) is not allowed; it must be > 60 rpm",
    "study test_force --up-to '5 Hz'": "up-to = 5 Hz is not allowed; it must be > 5 Hz",
    "study h_matrix --rotor bare.toml": "bearing 'left' has no sensors: the rotor has no sensor planes",
    "study h_matrix --rotor blind.toml": "bearing 'right' has no sensors of its own",
    "study recovery --steps '8,0 g.m'": "steps = 0 kg m (0 g.m) is not allowed; it must be > 0 kg m",
    "study recovery --instants 0": "instants = 0 is not allowed; it must be from 1 to 1000",
    "study recovery --alpha -1": "alpha = -1 1/s is not allowed; it must be >= 0 1/s",
    f"study convergence --starts {MANY}": "it must be from 0 to 1000",
    "identify --speeds 0": "speeds = 0 rpm is not allowed; it must be >= 300 rpm, rolac.min_speed",
    "identify --speeds '5e-324 rad/s'": "speeds = 5e-324 rad/s is not allowed; it must be from 1e-100",
    "identify --set Omega=90rad/s": "Omega cannot be set here; speeds sets it",
    "identify -o no/t.toml": "no/t.toml cannot be written to; there is no folder no",
}

RESULTS = {
    "study contact_laws --speed 0": "speed = 0 m/s is not allowed; it must be > 0 m/s",
    "study contact_laws --restitution 0.1": "restitution = 0.1 is not allowed; it must be from 0.15 to 1",
    "study recovery --steps 0.008,0.012": "--steps 0.012 has no unit; write for example '8,12,16 g.m'",
    "study contact_laws --delta-c '1e12 m'": "does not leave the retainer within",
    "study waterfall run --window '5 s'": "window = 5 s is not allowed; it must be >= 0.016 s and <=",
    "study waterfall run --up-to 0": "up-to = 0 Hz is not allowed; it must be > 0 Hz",
    "study waterfall run --set a.b=1": "run is a saved result; its settings cannot be changed",
    "plot run orbit": "did you mean orbits",
    "new pump --mass '60 kg' --length '1.2 m'": "--speed is missing",
    "compare fig4_9": "compare needs 2 to 8 runs, not 1",
    "compare fig4_9 fig4_99": "fig4_99",
    "compare fig4_9 empty": "no result empty/result.nc",
    "compare fig4_9 run --set 2:a.b=1": "run is a saved result; {'a.b': '1'} cannot be set for it",
    "compare run run --set a.b=1": "settings require a scenario; all of these are saved",
    "compare run run --set 3:a.b=1": "there is no run 3; it must be from 1 to 2",
    "compare fig4_9 fig4_9 --flavour 2:java": "flavour = 'java' is not allowed",
    "sweep fig4_9": "nothing is varied",
    "sweep fig4_9 --vary Omega=1:2Hz": "Omega has no count",
    f"{SWEEP} --sample boundary:contact --certainty 3": "certainty = 3 is not allowed; it must be",
    f"{SWEEP} --sample boundary:shape": "sample = 'boundary:shape' is not allowed",
    f"{SWEEP} --boundary shape": "boundary = 'shape' is not allowed",
    f"{SWEEP} --keep nothing": "keep = 'nothing' is not allowed",
    f"{SWEEP} --metric missing.py:f": "--metric missing.py:f is not allowed",
}


@pytest.mark.parametrize(("command", "message"), (RUN | ANALYSES | CONTROL | RESULTS).items())
def test_bad_input_ends_with_one_message_and_nothing_written(folder, refuses, command, message):
    refuses(message, *shlex.split(command))


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes")
@pytest.mark.parametrize("arguments", [["run"], ["rotor", "show"], ["new"], ["list"], ["sweep", "a.toml", "-o"]])
def test_names_of_files_that_are_not_utf_8_are_refused(arguments, tmp_path):
    done = run_command(*arguments, "a\udcff.toml", cwd=tmp_path, code=2)
    assert done.stderr == "amb-cosim: argument 'a\\udcff.toml' is not UTF-8; rename the file or folder\n"
    assert [*tmp_path.iterdir()] == []


def test_a_pack_without_scenarios_has_no_robustness(refuses, tmp_path, monkeypatch):
    monkeypatch.setattr("amb_files.packs.packs", lambda: {"mine": tmp_path})
    refuses("pack 'mine' has neither scenarios nor statements about one", "report", "--robustness", "--pack", "mine")
