"""Extreme numbers, units and files end with one message, quickly."""

import os

import pytest

CHANGES = {
    "settle": ("settle_cycles = 1e308", "settle_cycles = 1e+308 is not allowed; it must be >= 0 and <= 1e+09"),
    "end": ("end_cycle = 1e308", "end_cycle = 1e+308 is not allowed; it must be"),
    "end in time": ("remove = ['end_cycle']\nend_time = '1e99 s'", "stop_time = 1e+99 s is not allowed"),
    "event": ("[[event]]\ncycle = 1e308\nset.rotor_contact.'d1.u' = 1", "event[0].cycle = 1e+308 is not allowed"),
    "digits of a cycle": ("end_cycle = " + "1" * 400, "end_cycle = 1111111111"),
    "thousands of digits": (f"Omega = {'1' * 5000}", "scenario mine.toml is not valid TOML: Exceeds the limit"),
    "every": (f"record.every = {'1' * 400}", "record.every = 1111111111"),
    "more lists": (f"a = {'[' * 100_000}{']' * 100_000}", "its tables and lists are nested more than 100 levels deep"),
    "tables": (f"[{'.'.join(['a'] * 900)}]\nb = 1", "its tables and lists are nested more than 100 levels deep"),
    "dotted key": (f"{'.'.join(['a'] * 100_000)} = 1", "its tables and lists are nested more than 100 levels deep"),
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
    for command in (["run", "fig4_9", "--rotor"], ["study", "modes", "--rotor"], ["rotor", "show"]):
        refuses("rotor file rotor.toml cannot be read: it ", *command, "rotor.toml")
