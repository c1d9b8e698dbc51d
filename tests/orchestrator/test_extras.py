"""Python without the packages of extras: a plain run works, and errors of other commands name what to install."""

from pathlib import Path

import pytest

import amb_cosim
from fmi_export.building.extras import install_command
from tests.support.messages import assert_names

BLOWER = Path(__file__).parents[1] / "amb_assessment" / "assessment" / "blower" / "machine.toml"


def without_extras(arguments: list[str]) -> tuple[object, str, str]:
    """Exit code of a command, what it prints, and what it says of errors."""
    import contextlib
    import io

    from hide import hide

    hide("SALib", "bokeh", "dask", "distributed", "narwhals", "plotly", "zarr", "ziglang")
    from amb_cosim.commands.cli import main

    printed, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        try:
            main(arguments)
        except SystemExit as end:
            return end.code, printed.getvalue(), errors.getvalue()


def test_a_plain_run_needs_no_extra(run_python, tmp_path):
    amb_cosim.run("fig4_9", until=0.01)  # which may compile what an installed package has with it
    code, _, errors = run_python(without_extras, cwd=tmp_path, arguments=["run", "fig4_9", "--until", "0.05"])
    assert code == 0, errors
    assert (tmp_path / "results" / "fig4_9" / "orbits.png").is_file()


@pytest.mark.slow
def test_an_assessment_without_plotly_has_its_answer_and_data(run_python, tmp_path):
    arguments = ["assess", str(BLOWER), "--only", "closed_loop", "-o", "judged"]
    code, printed, errors = run_python(without_extras, cwd=tmp_path, arguments=arguments)
    assert code == 0, errors
    assert printed.startswith("Yes: all")
    assert_names(printed, "judged/assessment.json", "page needs plotly", "[report]")
    assert [path.name for path in (tmp_path / "judged").iterdir()] == ["assessment.json"]


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
    code, _, message = run_python(without_extras, cwd=tmp_path, arguments=command.split())
    assert (code, message.endswith(f"{needs}, not installed: {install_command(extra)}\n")) == (2, True), message
