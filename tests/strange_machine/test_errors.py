"""Bad input for a machine with names unlike the rig's: one message with value and allowed range."""

import re
import shlex
import shutil
import tomllib

import pytest
import tomli_w
from click.testing import CliRunner
from strange_machine import FOLDER, ROTOR

from amb_cosim.commands.cli import main

OF_THE_RIG = re.compile(r"\b([mr]b[12]|d[1-4]|fig\d\w*|bath|abulrub|thesis|the rig)\b", re.IGNORECASE)

WITHOUT = {"bare.toml": "sites", "loose.toml": "bearings", "blind.toml": "sensors"}  # rotor files, and what they lack

COMMANDS = {
    "run levitation.toml --rotor bare.toml": "rotor_contact has no parameter or input '*.mu'; there are ",
    "run levitation.toml --rotor loose.toml": "(catch_n) = 'north' is not the name of a bearing; there are none",
    "run levitation.toml --rotor expandor": "rotor = 'expandor' is not allowed; did you mean turbo_expander?",
    "run expander.toml": "unknown keys shaft, materials, bodies, ",
    "rotor show levitation.toml": "unknown keys description, system, rotor, ",
    "assess --check expander.toml": "bearings, seals, sites, sensors, damping, reduction; there are ",
    "assess --check wrong.toml": "rotor expander has no part 'turbin'; did you mean turbine?",
    "assess machine.toml --only closed_lop": "no part 'closed_lop'; did you mean closed_loop?",
    "assess machine.toml --criteria text.toml": "criteria text.toml is not valid TOML",
    "assess machine.toml -o text.toml": "it is a file, and the output must be a folder",
    "report --units m/s": "units = 'm/s' is not allowed",
    "live levitation.toml --rotor nope.toml": "levitation: rotor = 'nope.toml' is not allowed; there is no file nope",
    "verify text.toml": "cannot be unpacked: it is not a zip archive",
    "assess machine.toml --units furlong": "units = 'furlong' is not allowed; it must be one of rad/s, Hz, rpm",
    "study modes --rotor expander.toml --speeds '100 Hz, 12000'": "--speeds 12000 has no unit; write for example",
    "study poles levitation.toml --up-to 12000": "--up-to 12000 has no unit; write for example '12000 rpm'",
    "new fan --mass 60kg --length 1m --speed 12000": "--speed 12000 has no unit; write for example '12000 rpm'",
    "study h_matrix --rotor blind.toml": "bearing 'north' has no sensors",
    "study traps levitation.toml --set rotor_contact.catch_n.mew=1": "did you mean catch_n.m",
    "identify --rotor blind.toml": "bearing 'north' has no sensors",
    "sweep levitation.toml --vary rotor_contact.turbine.u=1m,2m": "has unit m, which cannot be converted to kg.m",
    "sweep levitation.toml --vary step.rotor_contact.turbine.u=5:40:5": (
        "add the intended unit, such as step.rotor_contact.turbine.u='5 kg.m'"
    ),
    "sweep levitation.toml --vary rotor_contact.turbine.u=5:40:3": (
        "add the intended unit, such as rotor_contact.turbine.u='5 kg.m'"
    ),
    "run levitation.toml --set rotor_contact.turbine.u=5": (
        "add the intended unit, such as rotor_contact.turbine.u='5 kg.m'"
    ),
    "compare levitation.toml levitation.toml --set 2:rotor_contact.turbine.u=5": "rotor_contact.turbine.u='5 kg.m'",
    "study sensitivity levitation.toml --set amb_actuator.north.bias_current_x=1000": "bias_current_x='1000 A'",
    "run levitation.toml --set rotor_contact.catch_?.clearance=0.09": "rotor_contact.catch_?.clearance='0.09 m'",
    "study poles levitation.toml --up-to '12,000 rpm'": "a single number as 12000 or 12.000",
    "study traps levitation.toml --unbalance 20": "--unbalance 20 has no unit; write for example '20 g.m'",
    "study traps levitation.toml --unbalance-up-to 20": "--unbalance-up-to 20 has no unit",
    "study unbalance_response levitation.toml --unbalance 20": "--unbalance 20 has no unit",
    "study response levitation.toml --up-to 1000": "--up-to 1000 has no unit; write for example '100 Hz'",
    "study linearisation levitation.toml --bias-current 4": "--bias-current 4 has no unit; write for example '4 A'",
    "study linearisation levitation.toml --static-current 1": "--static-current 1 has no unit",
    "study sensitivity levitation.toml --sample-time 1e-4": "--sample-time 1e-4 has no unit",
    "study receptance levitation.toml --k-b 1e6": "--k-b 1e6 has no unit; write for example '1e6 N/m'",
    "study receptance levitation.toml --c-b 5000": "--c-b 5000 has no unit; write for example '5000 N.s/m'",
    "controller import law.mat --sample-time 1e-4": "--sample-time 1e-4 has no unit",
    "new fan --mass 60kg --length 1m --speed 12000rpm --bearings '0.2 0.8'": "--bearings 0.2 has no unit",
    "new fan --mass 60kg --length 1m --speed 12000rpm --bearings '0.2 m, 0.8'": "--bearings 0.8 has no unit",
    "rotor import text.toml --frequency 100": "--frequency 100 has no unit; write for example '100 Hz'",
    "new fan --mass 60 --length 1m --speed 12000rpm": "--mass 60 has no unit; write for example '60 kg'",
    "new fan --mass 60kg --length 1 --speed 12000rpm": "--length 1 has no unit",
    "new fan --mass 60kg --length 1m --speed 12000rpm --k-i 210 --k-s '1.5e6 N/m'": "--k-i 210 has no unit",
    "new fan --mass 60kg --length 1m --speed 12000rpm --k-i '0 N/A' --k-s '1.5e6 N/m'": (
        "K_i = 0 N/A is not allowed; it must be > 0 N/A"
    ),
    "new fan --mass 60kg --length 1m --speed 12000rpm --k-i '210 N/A' --k-s '0 N/m'": "K_s = 0 N/m is not allowed",
    "compare levitation.toml levitation.toml --set 2:rotor_contact.turbin.u=1": "did you mean turbine.u",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the machine, rotors that lack something, a machine with a wrong name, and a text."""
    made = tmp_path_factory.mktemp("machine")
    rotor, machine = (path.read_text(encoding="utf-8") for path in (ROTOR, FOLDER / "machine.toml"))
    for file in FOLDER.glob("*.toml"):
        shutil.copy(file, made)
    for name, lacks in WITHOUT.items():
        (made / name).write_text(tomli_w.dumps({key: of for key, of in tomllib.loads(rotor).items() if key != lacks}))
    (made / "wrong.toml").write_text(machine.replace('"turbine"', '"turbin"'))
    (made / "text.toml").write_text("hello")
    return made


@pytest.mark.parametrize(("command", "message"), COMMANDS.items())
def test_errors_use_the_names_of_the_machine(folder, monkeypatch, command, message):
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    ended = CliRunner().invoke(main, shlex.split(command))
    assert (ended.exit_code, type(ended.exception)) == (2, SystemExit), ended.output
    assert message in ended.output
    assert all(line.startswith("amb-cosim: ") for line in ended.output.splitlines())
    assert not OF_THE_RIG.search(ended.output)
    assert sorted(folder.iterdir()) == before
