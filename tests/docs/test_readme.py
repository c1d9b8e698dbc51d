"""What README states of its run, the picture at its top and the machine code is so."""

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import run_command
from PIL import Image

from amb_cosim import studies
from amb_cosim.results.result import Result
from fmi_export.building.native.compiler import PLATFORMS
from tools.gallery.__main__ import reduce

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FRICTION = 0.05  # at least, of a retainer that a reader would believe


@pytest.fixture(scope="module")
def command():
    code = README.partition("<!-- command: run -->")[2].partition("```sh\n")[2].partition("\n")[0]
    return code.rpartition("&& amb-cosim ")[2].split()


@pytest.fixture(scope="module")
def run(command, tmp_path_factory):
    """The folder of the results, and what the command prints."""
    folder = tmp_path_factory.mktemp("readme")
    printed = run_command(*command, cwd=folder).stdout
    return folder / "results" / command[1], printed.splitlines()


@pytest.fixture(scope="module")
def result(run):
    return Result.load(run[0])


def test_the_output_is_quoted_whole(run):
    quoted = README.partition("```text\n")[2].partition("```")[0].splitlines()
    assert [line.rstrip() for line in run[1] if line.strip()] == quoted


def test_the_picture_at_the_top_is_that_of_the_run(run, tmp_path):
    """Pixels of the committed picture and of one drawn now, reduced alike."""
    shown = ROOT / re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README)[0]
    (drawn,) = re.findall(r"picture at the top is `results/\w+/(\w+\.png)`", README)
    with Image.open(shown) as committed:
        expected = np.asarray(committed.convert("L"), float)
    reduce(run[0] / drawn, tmp_path / "now.png", expected.shape[1])
    with Image.open(tmp_path / "now.png") as now:
        drawn_now = np.asarray(now.convert("L"), float)
    assert drawn_now.shape == expected.shape
    assert np.abs(drawn_now - expected).mean() < 1.0  # of 255


def test_the_rotor_slides_with_friction_within_the_limits_of_its_magnets(result):
    data = result.dataset
    for site in ("rb1", "rb2", "eb1", "eb2"):
        sliding = data[f"rotor_contact.{site}.mode"].values == 1
        ratio = (
            np.abs(data[f"rotor_contact.{site}.f_t"].values[sliding])
            / data[f"rotor_contact.{site}.f_n"].values[sliding]
        )
        assert np.median(ratio) > FRICTION
    shares = [fact for label, fact in result.summary.verdict.facts if label.startswith("largest c") and "%" in fact]
    shares += [fact for label, fact in result.summary.verdict.facts if label == "largest magnet force"]
    assert len(shares) == 2
    assert all(float(text.partition(" %")[0]) < 100.0 for text in shares)


def test_amplifiers_are_at_their_voltage_limit_only_after_the_power_returns(result):
    (stated,) = re.findall(r"for the first (\d+) ms after power\s+returns", README)
    data = result.dataset
    limited = [data[f"amb_actuator.mb{k}.voltage_limited_{axis}"].values > 0 for k in (1, 2) for axis in "xy"]
    when = data["time"].values[np.any(limited, axis=0)] - data["time"].values[np.argmax(data["cycle"].values >= 0.0)]
    assert 0.5 <= when.min() < when.max() <= 0.5 + 1e-3 * float(stated)


@pytest.mark.slow
def test_the_largest_contact_force_converges_as_stated():
    """With 40 shapes in place of 20."""
    rows = {row.label: row for row in studies.convergence("relevitation", progress=False).rows if row.start == 0}
    base, doubled = rows["scenario"].sites, rows["40 shapes"].sites
    change = {site: abs(doubled[site].mean_force / base[site].mean_force - 1.0) for site in base}
    largest = max(base, key=lambda site: base[site].mean_force)
    of_largest, of_others = re.findall(r"changes by less than ([\d.]+) %.*?by up to ([\d.]+) %", README, re.DOTALL)[0]
    assert change[largest] < 0.01 * float(of_largest)
    assert max(change.values()) == pytest.approx(0.01 * float(of_others), abs=0.005)


def test_machine_code_is_for_the_platforms_stated():
    native = [platform for platform in PLATFORMS if "wasm" not in platform]
    assert f"{ {5: 'five'}.get(len(native)) } platforms and the browser" in README
    assert {"linux", "win", "darwin"} == {re.match(r"[a-z]+", re.sub(r"^(x86_64|aarch64)-", "", p))[0] for p in native}


def test_it_is_short():
    prose = re.sub(r"```.*?```", "", README, flags=re.DOTALL)
    assert len(prose.split()) < 750
    table = README.partition("| --- |")[2].partition("\n\n")[0]
    assert table.count("\n| ") <= 6
    assert README.partition("## Read on")[2].count("\n- ") == 5


def test_tutorials_contain_their_commands():
    """As `docs/index.md` says."""
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "Each tutorial contains all of its commands." in index
    for page in re.findall(r"\]\((tutorials/\w+\.md)\)", index):
        assert re.search(r"^```(sh|python)", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.MULTILINE), page
