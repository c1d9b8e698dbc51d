"""Where results go: devices, pipes, links, full disks."""

import json
import os

import pytest
from slow import slow_but_first

from amb_cosim.cosim.run.dataset import load
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.result import Result
from fmi_export.building.native import engines

SHORT = ("run", "fig4_9", "--until", "0.02", "--no-plots")


def test_a_summary_is_written_to_the_file_or_the_device_behind_a_link(runner, tmp_path):
    target, link, null = (tmp_path / name for name in ("target.json", "link.json", "null"))
    target.write_text("mine")
    link.symlink_to(target)
    null.symlink_to(os.devnull)
    for path in (link, null):
        assert runner(*SHORT, "--summary-json", path.name).exit_code == 0
    assert link.is_symlink()
    assert json.loads(target.read_text())["scenario"] == "fig4_9"
    assert null.is_char_device()


@pytest.mark.parametrize("suffix", slow_but_first(["png", "svg", "csv", "mat"]))
def test_plot_writes_to_the_targets_of_links(runner, tmp_path, suffix):
    """That of the file that the user names, and that of its own name in the folder of the result."""
    assert runner(*SHORT, "-o", "out").exit_code == 0
    link, own = tmp_path / f"link.{suffix}", tmp_path / "out" / "traces.png"
    for path in (link, own):
        path.symlink_to(tmp_path / f"target_of_{path.name}")
    assert runner("plot", "out", "mb1.x", "-o", link.name).exit_code == 0
    assert runner("plot", "out", "mb1.x").exit_code == 0
    assert all(path.is_symlink() and path.stat().st_size > 0 for path in (link, own))


@pytest.mark.slow
def test_a_full_disk_ends_with_one_message_and_keeps_the_old_result(cosim, small_disk):
    disk = small_disk("1500k")
    assert cosim(*SHORT, "-o", "disk").returncode == 0
    before = (disk / "result.nc").read_bytes()
    done = cosim("run", "fig4_9", "--no-plots", "-o", "disk")
    assert done.returncode == 1
    assert done.stderr.splitlines() == ["amb-cosim: disk/result.nc: No space left on device"]
    assert (disk / "result.nc").read_bytes() == before
    assert sorted(path.name for path in disk.iterdir()) == ["result.nc", "summary.json"]
    assert load(disk / "result.nc").sizes["time"] == 81


def test_a_full_cache_is_named(runner, small_disk, monkeypatch, cache):
    disk = small_disk("100k")
    if not engines.SHIPPED.is_dir():  # as in an installed package
        monkeypatch.setattr(engines, "SHIPPED", cache / "amb-cosim" / "engines")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name, *_, **__: disk / name)
    result = runner(*SHORT)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"amb-cosim: {disk}/amb-cosim/")
    assert line.endswith("No space left on device")


def test_a_result_follows_links_in_its_folder(synthetic, tmp_path):
    (tmp_path / "out").mkdir()
    names = ("result.nc", "summary.json", "orbits.png")
    for name in names:
        (tmp_path / "out" / name).symlink_to(tmp_path / name)
    outcome = Outcome("completed", 0.4)
    Result(synthetic(outcome='["completed", 0.4, null, ""]', plot_figures='["orbits"]'), outcome).save(tmp_path / "out")
    assert all((tmp_path / "out" / name).is_symlink() and (tmp_path / name).stat().st_size > 0 for name in names)
    assert load(tmp_path / "result.nc").sizes["time"] == 2001
