"""Python without the packages of extras: a plain run works, and errors of other commands name what to install."""

import pytest

import amb_cosim
from fmi_export.building.extras import install_command


def without_extras(arguments: list[str]) -> tuple[object, str]:
    """Exit code of a command and what it says of errors."""
    import contextlib
    import io

    from hide import hide

    hide("SALib", "bokeh", "dask", "distributed", "narwhals", "plotly", "zarr", "ziglang")
    from amb_cosim.commands.cli import main

    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        try:
            main(arguments)
        except SystemExit as end:
            return end.code, errors.getvalue()


def test_a_plain_run_needs_no_extra(run_python, tmp_path):
    amb_cosim.run("fig4_9", until=0.01)  # which may compile what an installed package has with it
    code, errors = run_python(without_extras, cwd=tmp_path, arguments=["run", "fig4_9", "--until", "0.05"])
    assert code == 0, errors
    assert (tmp_path / "results" / "fig4_9" / "orbits.png").is_file()


NATIVE = "it needs ziglang"


@pytest.mark.parametrize(
    ("command", "needs", "extra"),
    [
        ("report", "a report needs plotly", "report"),
        ("sweep fig4_9 --vary Omega=200:260rad/s:2", "distributed, zarr, SALib", "sweep"),
        pytest.param("build --platform aarch64-linux", NATIVE, "native", marks=pytest.mark.slow),
        pytest.param("build --flavour python --platform win64", NATIVE, "native", marks=pytest.mark.slow),
    ],
)
def test_error_of_a_command_names_the_missing_extra(run_python, tmp_path, monkeypatch, command, needs, extra):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "empty"))
    monkeypatch.chdir(tmp_path)  # the command that installs it names the clone from elsewhere
    code, message = run_python(without_extras, cwd=tmp_path, arguments=command.split())
    assert (code, message.endswith(f"{needs}, not installed: {install_command(extra)}\n")) == (2, True), message
