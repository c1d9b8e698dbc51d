"""Numbers, units and files beyond all measure end with one message, quickly."""

from __future__ import annotations

import os

import pytest

CLEARANCE = "rotor_contact.rb1.clearance="

ARGUMENTS = {
    "end": (["run", "fig4_9", "--until", "1e308"], "until = 1e+308 s is not allowed; it must be within 2.5e+08 s"),
    "long end": (["run", "fig4_9", "--until", "1e15"], "until = 1e+15 s is not allowed"),
    "tiny end": (["run", "fig4_9", "--until", "1e-308"], "until = 1e-308 s is not allowed"),
    "digits": (["run", "fig4_9", "--set", CLEARANCE + "1" * 400], "rotor_contact.rb1.clearance = 1111111111"),
    "by zero": (["run", "fig4_9", "--set", CLEARANCE + "1 m/0"], "unknown unit 'm/0'"),
    "comment": (["run", "fig4_9", "--set", CLEARANCE + "0.6 #"], "unknown unit '#'"),
    "many factors": (["run", "fig4_9", "--set", CLEARANCE + "1 " + "m." * 3000 + "m"], "unknown unit 'm.m.m.m."),
    "powers": (["run", "fig4_9", "--set", CLEARANCE + "1 m**9**9**9**9"], "unknown unit 'm**9**9**9**9'"),
    "speed": (["run", "fig4_9", "--set", "Omega=1e-99"], " s is not allowed; it must be within 2.5e+08 s"),
    "identified": (["identify", "--speeds", "5e-324"], "speeds = 5e-324 is not allowed; it must be from 1e-100"),
    "identified slowly": (["identify", "--speeds", "1e-99"], " is not allowed; it must be "),
    "current": (["study", "linearisation", "--bias-current", "1e-300"], "bias-current = 1e-300 is not allowed"),
    "small current": (["study", "linearisation", "--bias-current", "1e-99"], "bias-current = 1e-99 A is not allowed"),
    "starts": (["study", "convergence", "--starts", "1" * 400], "it must be from 0 to 1000"),
    "instants": (["study", "recovery", "--instants", "1" * 400], "it must be from 1 to 1000"),
    "stiffness": (["study", "receptance", "--k-b", "1e300"], "k-b = 1e300 is not allowed"),
    **{
        f"{study} up to {speed}": (["study", study, "--up-to", speed], "up-to = ")
        for study in ("campbell", "tables", "unbalance_response", "receptance", "test_force", "h_matrix")
        for speed in ("1e308", "1e15")
    },
}  # fmt: skip


@pytest.mark.parametrize("case", ARGUMENTS)
def test_an_extreme_argument_is_refused(runner, tmp_path, case):
    arguments, message = ARGUMENTS[case]
    result = runner(*arguments)
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


CHANGES = {
    "settle": ("settle_cycles = 1e308", "settle_cycles = 1e+308 is not allowed; it must be >= 0 and <= 1e+09"),
    "endless settling": ("settle_cycles = inf", "settle_cycles = inf is not allowed"),
    "end": ("end_cycle = 1e308", "end_cycle = 1e+308 is not allowed; it must be"),
    "end in time": ("remove = ['end_cycle']\nend_time = '1e99 s'", "stop_time = 1e+99 s is not allowed"),
    "event": ("[[event]]\ncycle = 1e308\nset.rotor_contact.'d1.u' = 1", "event[0].cycle = 1e+308 is not allowed"),
    "digits of a cycle": ("end_cycle = " + "1" * 400, "end_cycle = 1111111111"),
    "digits of a value": (f"[parameters.rotor_contact]\n'rb1.clearance' = {'1' * 400}", "clearance = 1111111111"),
    "thousands of digits": (f"Omega = {'1' * 5000}", "scenario mine.toml is not valid TOML: Exceeds the limit"),
    "every": (f"record.every = {'1' * 400}", "record.every = 1111111111"),
    "lists": (f"a = {'[' * 2000}{']' * 2000}", "its tables and lists lie more than 100 deep"),
    "more lists": (f"a = {'[' * 100_000}{']' * 100_000}", "its tables and lists lie more than 100 deep"),
    "tables": (f"[{'.'.join(['a'] * 900)}]\nb = 1", "its tables and lists lie more than 100 deep"),
    "dotted key": (f"{'.'.join(['a'] * 100_000)} = 1", "its tables and lists lie more than 100 deep"),
}


@pytest.mark.parametrize("case", CHANGES)
def test_an_extreme_scenario_is_refused(refuses, tmp_path, case):
    text, message = CHANGES[case]
    (tmp_path / "mine.toml").write_text(f"base = 'fig4_9'\n{text}\n")
    refuses(message, "run", "mine.toml")


@pytest.mark.parametrize(("command", "kind", "last"), [
    ("run", "scenario", "base = 'fig4_9'"),
    ("simulate", "system", "base = 'levitated'"),
])  # fmt: skip
def test_a_thousand_bases_are_refused(refuses, tmp_path, command, kind, last):
    for k in range(1200):
        (tmp_path / f"{k}.toml").write_text(f"base = '{k + 1}.toml'")
    (tmp_path / "1200.toml").write_text(last)
    refuses("a file must have <= 20 bases", command, "0.toml")


@pytest.mark.parametrize("kind", ["pipe", "endless device", "large file"])
def test_a_rotor_file_that_is_no_regular_file_is_refused(refuses, tmp_path, kind):
    path = tmp_path / "rotor.toml"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "endless device":
        path.symlink_to("/dev/zero")
    else:
        path.touch()
        os.truncate(path, 10 * 2**30)
    for command in (["run", "fig4_9", "--rotor"], ["modes", "--rotor"], ["rotor", "show"]):
        refuses("rotor file rotor.toml cannot be read: it ", *command, "rotor.toml")
