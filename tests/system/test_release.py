"""The release command: reproducible notes, checks and archives."""

import os
import re
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CHANGELOG = (
    "# All\n\n## Unreleased\n\n- Later.\n\n## 0.2.0 - 2026-01-02\n\n- A shaft.\n- A seal.\n\n## 0.1.0\n\n- First.\n"
)
PREPARED = {
    "pyproject.toml": 'fallback-version = "0.2.0" # the last\n',
    "CITATION.cff": "version: 0.2.0\n",
    "CHANGELOG.md": CHANGELOG,
}


@pytest.fixture(scope="module")
def release():
    spec = spec_from_file_location("release", ROOT / ".ci" / "release.py")
    assert spec
    assert spec.loader
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_notes_are_those_of_the_version_or_unreleased(release):
    assert release.notes(CHANGELOG, "0.2.0") == "# amb-cosim 0.2.0\n\n- A shaft.\n- A seal.\n"
    assert release.notes(CHANGELOG, "0.1.0") == "# amb-cosim 0.1.0\n\n- First.\n"
    assert release.notes(CHANGELOG, "0.2.1.dev3") == "# amb-cosim 0.2.1.dev3\n\n- Later.\n"


def test_the_changelog_has_notes_for_each_release(release):
    """Those of the next may be empty just after a release."""
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## (\S+)", changelog, re.MULTILINE)
    assert versions[0] == "Unreleased"
    of_all = {version: release.notes(changelog, version) for version in versions}
    assert all("\n## " not in notes for notes in of_all.values())
    assert all(notes.count("\n- ") > 1 for version, notes in of_all.items() if version != "Unreleased")
    assert release.notes(changelog, "9.9.1.dev3").partition("\n")[2] == of_all["Unreleased"].partition("\n")[2]


def test_notes_have_no_links_to_files_beside_the_changelog(release):
    links = "[a page](docs/a.md#b), [a part](#b), [a site](https://example.org/)"
    written = release.notes(f"## Unreleased\n\n- {links}.\n", "0.2.1.dev1")
    assert written.endswith("- a page, [a part](#b), [a site](https://example.org/).\n")


def prepare(folder, **changed):
    for name, text in {**PREPARED, **changed}.items():
        (folder / name).write_text(text, encoding="utf-8")


def test_a_development_version_and_a_prepared_release_are_made(release, tmp_path):
    prepare(tmp_path)
    release.check_version(tmp_path, "0.2.0")
    release.check_version(tmp_path, "0.2.1.dev3")


@pytest.mark.parametrize("name", PREPARED)
def test_a_tag_without_its_version_in_every_file_is_refused(release, tmp_path, name):
    prepare(tmp_path, **{name: PREPARED[name].replace("0.2.0", "0.2.00")})
    with pytest.raises(SystemExit) as raised:
        release.check_version(tmp_path, "0.2.0")
    assert name in str(raised.value)
    assert "0.2.0" in str(raised.value)


def test_an_archive_of_a_folder_depends_on_its_content_alone(release, tmp_path):
    for folder, names in (("one", ("a", "b/c")), ("two", ("b/c", "a"))):
        for name in names:
            path = tmp_path / folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(name)
    os.utime(tmp_path / "two" / "a", (1e9, 1e9))
    for folder in ("one", "two"):
        release.archive(tmp_path / folder, tmp_path / f"{folder}.zip")
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "two.zip").read_bytes()
    assert release.differences(tmp_path / "one", tmp_path / "two") == []
    (tmp_path / "two" / "a").write_text("other")
    (tmp_path / "one" / "d").touch()
    assert release.differences(tmp_path / "one", tmp_path / "two") == ["a", "d"]


def test_the_site_of_a_release_has_the_table_of_statements(release, tmp_path, monkeypatch):
    """The page shows it only if the report has run in the same folder before."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "mkdocs"))
    import declarations

    table, ran = declarations.REPORT.relative_to(ROOT), []

    def run(*command, cwd):
        arguments = [str(part) for part in command]
        ran.append("mkdocs" if "mkdocs" in arguments else arguments[1])
        if ran[-1] == "report":
            assert arguments[2:] == [], "into the folder that the page reads"
            (cwd / table).parent.mkdir(parents=True)
            (cwd / table).touch()
        else:
            assert (cwd / table).exists()

    monkeypatch.setattr(release, "run", run)
    release.build_site(tmp_path / "tools", tmp_path, tmp_path / "site")
    assert ran == ["report", "mkdocs"]


def test_the_report_writes_where_the_page_of_statements_reads():
    from source_check.report_command import report
    from source_check.statements import packs_with_statements
    from source_check.table import TABLE

    (output,) = (option.default for option in report.params if option.name == "output")
    sys.path.insert(0, str(ROOT / "docs" / "mkdocs"))
    import declarations

    sys.path.pop(0)
    assert len(packs_with_statements()) == 1, "several packs have a folder each"
    assert ROOT / str(output) / TABLE == declarations.REPORT


def test_a_release_runs_the_scenario_of_the_readme(release):
    from amb_cosim.scenario.scenario import load_scenario

    assert load_scenario(release.scenario_of((ROOT / "README.md").read_text(encoding="utf-8")))


def test_the_archive_of_a_release_is_for_parallel_masters(release, tmp_path):
    """With the order of the scenario itself they make its loop unstable."""
    from amb_cosim.scenario.scenario import load_scenario

    name = release.scenario_of((ROOT / "README.md").read_text(encoding="utf-8"))
    written = load_scenario(str(release.in_parallel_order(name, tmp_path)))
    assert written == load_scenario(name).changed(coupling="jacobi")


@pytest.mark.slow
def test_the_source_archive_has_the_same_bytes_from_any_folder(tmp_path):
    pytest.importorskip("hatch_vcs")
    if not (ROOT / ".git").exists():
        pytest.skip("is no clone")
    made = []
    for name in ("one", "other/folder"):
        source = tmp_path / name
        subprocess.run(["git", "clone", "-q", ROOT, source], check=True)
        build = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path / f"dist {len(made)}"]
        subprocess.run(build, cwd=source, env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"}, check=True)
        (archive,) = (tmp_path / f"dist {len(made)}").glob("*.tar.gz")
        made.append(archive.read_bytes())
    assert made[0] == made[1]
