"""The command that installs an extra fits how the package was installed."""

import json
from types import SimpleNamespace

import pytest

from fmi_export.building import extras


@pytest.mark.parametrize(
    ("source", "command"),
    [
        (None, "pip install 'amb-cosim[sweep]'"),
        ({"url": "https://host/amb_cosim.whl", "archive_info": {}}, "pip install 'amb-cosim[sweep]'"),
        ({"url": "file:///home/me/my%20clone", "dir_info": {}}, "pip install '/home/me/my clone[sweep]'"),
        ({"url": "file:///home/me/clone", "dir_info": {"editable": True}}, "pip install -e '/home/me/clone[sweep]'"),
    ],
)
def test_the_command_for_an_extra_fits_the_installation(monkeypatch, source, command):
    record = SimpleNamespace(read_text=lambda _: None if source is None else json.dumps(source))
    monkeypatch.setattr(extras, "distribution", lambda _: record)
    assert extras.install_command("sweep") == command


def test_in_the_clone_itself_the_command_for_an_extra_names_no_path(monkeypatch, tmp_path):
    record = SimpleNamespace(read_text=lambda _: json.dumps({"url": tmp_path.as_uri(), "dir_info": {}}))
    monkeypatch.setattr(extras, "distribution", lambda _: record)
    monkeypatch.chdir(tmp_path)
    assert extras.install_command("report") == "pip install '.[report]'"
