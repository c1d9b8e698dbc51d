"""Packs are registered by entry points; a broken one is skipped with a warning."""

import sys
from importlib.metadata import Distribution, EntryPoint
from pathlib import Path

import pytest
from click.testing import CliRunner

from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_cosim.commands.cli import main
from amb_cosim.cosim.system.system_file import load_system, packaged_systems
from amb_cosim.scenario.file import read_scenario
from amb_files import pack_file, packs
from tests.support.messages import assert_names, raises_naming


@pytest.fixture
def installed(monkeypatch):
    """`installed({name: package})`: those packs alone, or those of entry points, until the test ends."""

    real = packs.entry_points

    def forget():
        packs.applications.cache_clear()
        packs.packs.cache_clear()
        packs.modules_of.cache_clear()
        pack_file.pack_files.cache_clear()

    def install(packages):
        points = packages
        if isinstance(packages, dict):
            points = [EntryPoint(name, package, packs.GROUP) for name, package in packages.items()]
        found = {packs.GROUP: points, packs.APPLICATIONS: []}  # models stay, since their cache outlives a test
        monkeypatch.setattr(packs, "entry_points", lambda group: found[group] if group in found else real(group=group))
        forget()

    yield install
    forget()


@pytest.fixture
def written(monkeypatch, tmp_path):
    """`written({package: {file: content}})`: packages that can be imported, until the test ends; their folders."""

    def write(packages):
        monkeypatch.syspath_prepend(tmp_path)
        for package, files in packages.items():
            for name, text in {"__init__.py": "", **files}.items():
                (tmp_path / package / name).parent.mkdir(parents=True, exist_ok=True)
                (tmp_path / package / name).write_bytes(text.encode(errors="surrogateescape"))
            for module in (package, f"{package}.commands"):
                monkeypatch.delitem(sys.modules, module, raising=False)
        return [tmp_path / package for package in packages]

    return write


@pytest.mark.parametrize("package", ["no_such", "no_such.sub", "..", "json.decoder", "", "a b"])
def test_a_broken_pack_is_skipped_with_a_warning(package, installed, capsys):
    installed({"good": "json", "broken": package})
    assert [*packs.packs()] == ["good"]
    assert_names(capsys.readouterr().err, "pack 'broken'", f"{package!r}")


def test_names_of_entry_points_are_shortened_in_warnings(installed, capsys):
    installed({"a" * 10**5: "no_such", "broken": "a." * 10**5})
    assert packs.packs() == {}
    assert len(capsys.readouterr().err) < 1000


@pytest.mark.parametrize("named", [True, False, None])
def test_broken_packs_of_one_distribution_have_one_warning(named, installed, capsys, tmp_path):
    folder = tmp_path / "flood-1.0.dist-info"
    folder.mkdir()
    lines = "".join(f"p{k} = no_such_{k}\n" for k in range(2000))
    (folder / "entry_points.txt").write_text(f"[{packs.GROUP}]\n{lines}good = json\n")
    if named is not None:  # otherwise there is no such file
        (folder / "METADATA").write_text("Metadata-Version: 2.1\n" + "Name: flood\nVersion: 1.0\n" * named)
    installed([*Distribution.at(folder).entry_points, EntryPoint("other", "no_such", packs.GROUP)])
    assert [*packs.packs()] == ["good"]
    other, flood = capsys.readouterr().err.splitlines()
    assert_names(flood, "'p0'", "'no_such_0'", "1999", "flood")
    assert_names(other, "'other'", "'no_such'")


@pytest.mark.parametrize(
    "code",
    [
        *("1 / 0", "raise SystemExit(3)", "import no_such_module", "raise ValueError('a\\nb')", "x ="),
        *("raise BaseException", "raise GeneratorExit", "raise ValueError('a' * 10**6)"),
        "class Odd(Exception):\n    __str__ = None\nraise Odd",
    ],
)
def test_a_module_that_fails_stops_only_its_own_commands(code, installed, written):
    written({"good_pack": {"commands.py": "COMMANDS = ()"}, "bad_pack": {"commands.py": code}})
    installed({"bad": "bad_pack", "good": "good_pack"})
    done = CliRunner().invoke(main, ["--help"])
    assert done.exit_code == 0
    (warning,) = (line for line in done.output.splitlines() if line.startswith("warning"))
    assert_names(warning, "pack 'bad'", "commands", "import")
    assert len(warning) < 400
    assert [*packs.modules_of("commands")] == ["good"]


def scenarios(*names):
    return {f"scenarios/{name}.toml": "" for name in names}


def test_a_name_of_two_packs_is_refused_when_used_and_others_are_not(installed, written, tmp_path):
    written({"one_pack": scenarios("drop", "fall"), "other_pack": scenarios("drop", "rub")})
    installed({"one": "one_pack", "other": "other_pack"})
    files = packs.files_of("scenarios")
    assert sorted(files) == ["fall", "rub"]
    assert files["rub"] == tmp_path / "other_pack" / "scenarios" / "rub.toml"
    assert "missing" not in files
    for use in (files.get, files.__getitem__, files.__contains__):
        with raises_naming(ValueError, "one", "other", "scenarios/drop.toml"):
            use("drop")
    assert len(files.clashes()) == 1


@pytest.mark.parametrize("other", ["a_pack", "z_pack"])
def test_packs_of_one_name_both_have_their_files(other, installed, written, tmp_path):
    """The name of an installed pack may be used by another one, which has nothing to do with its runs."""
    written({package: scenarios(f"{package}_drop") for package in (other, "m_pack")})
    entries = (("mine", "m_pack"), ("mine", other), ("again", "m_pack"), ("again", "m_pack"))
    installed([EntryPoint(name, package, packs.GROUP) for name, package in entries])
    assert sorted(packs.packs().values()) == sorted([tmp_path / "m_pack", tmp_path / other])
    assert {"m_pack_drop", f"{other}_drop"} == {*packs.files_of("scenarios", general=tmp_path / "m_pack")}


@pytest.mark.parametrize(
    "name", ["", "..", "../scenarios/fig4_9", "./fig4_9", "fig4_9.toml", "a\0b", "x" * 300, "FIG4_9"]
)
def test_only_names_of_files_in_the_folder_are_files_of_packs(name):
    assert name not in packs.files_of("scenarios")


def test_a_file_of_a_pack_is_found_without_listing_its_folder(monkeypatch):
    """A pack with thousands of scenarios, which are all read, would list them thousands of times."""
    files = dict(packs.files_of("scenarios"))
    monkeypatch.delattr(Path, "glob")
    assert {name: packs.files_of("scenarios")[name] for name in files} == files


@pytest.mark.parametrize("text", ["x = 1", "rotor = 3", "live = 'a'", "[", "\udce9"])
def test_an_invalid_pack_file_is_skipped_with_a_warning(text, installed, written, capsys):
    """It is read for the default rotor, which runs that have nothing to do with this pack use."""
    written({"pack_one": {"pack.toml": "rotor = 'mine'"}, "pack_bad": {"pack.toml": text}})
    installed({"bad": "pack_bad", "one": "pack_one"})
    assert pack_file.default("rotor") == "mine"
    (warning,) = capsys.readouterr().err.splitlines()
    assert_names(warning, "pack.toml", "bad")


@pytest.fixture
def two_packs(installed, written):
    """`two_packs({file: content})`: the folders of two installed packs that both have these files."""

    def make(files):
        installed({"a": "pack_a", "b": "pack_b"})
        return written({"pack_a": files, "pack_b": files})

    return make


@pytest.mark.parametrize("named", [True, False])
def test_a_scenario_has_the_default_rotor_of_its_own_pack(two_packs, named):
    """Another pack that defines a default stops no scenario of this one."""
    text = 'Omega = "9 rpm"\n' + 'rotor = "other"\n' * named
    files = {"pack.toml": 'rotor = "mine"', "rotors/mine.toml": "", "rotors/other.toml": ""}
    of_pack = {f"scenarios/{name}.toml": content for name, content in {"_base": text, "run": 'base = "_base"'}.items()}
    for folder in two_packs(files | of_pack):
        rotor = read_scenario(str(folder / "scenarios" / "run.toml"))["rotor"]
        assert rotor == str(folder / "rotors" / ("other.toml" if named else "mine.toml"))
    with raises_naming(ValueError, "a and b", "rotor"):
        pack_file.rotor_path()


def test_files_of_a_pack_mean_its_own_whatever_names_others_have(two_packs):
    files = {
        "systems/mine.toml": 'base = "levitated"\n',
        "systems/levitated.toml": '[[component]]\nname = "{0}"\nfmu = "x.fmu"\n',
        "scenarios/_base.toml": 'Omega = "9 rpm"\nsystem = "mine"\n',
        "scenarios/run.toml": 'base = "_base"\n',
        "machines/it.toml": 'scenario = "run"\nspeed = { minimum = "1 rpm", maximum = "9 rpm" }\n',
    }
    for folder in two_packs(files):
        scenario = folder / "scenarios" / "run.toml"
        assert load_machine(folder / "machines" / "it.toml").scenario == str(scenario)
        system = read_scenario(str(scenario))["system"]
        assert system == str(folder / "systems" / "mine.toml")
        (component,) = load_system(system).components
        assert component.fmu == str(folder / "systems" / "x.fmu")


@pytest.mark.parametrize("packages", [{}, {"amb_cosim": "pack_a"}, {"a": "pack_a", "b": "pack_b"}])
def test_a_name_of_amb_cosim_means_its_own_file(two_packs, installed, packages):
    """Whatever packs have a file of that name: each scenario runs in the system `levitated` by default."""
    two_packs({"systems/levitated.toml": "", "systems/mine.toml": "", "criteria/api_617.toml": ""})
    installed(packages)
    assert len(load_system("levitated").components) == 3
    assert "levitated" in [*packaged_systems()]
    assert (
        packaged_systems().clashes() == []
        if len(packages) < 2
        else ["packs a and b have systems/mine.toml; only one pack may contain this name"]
    )
    assert load_criteria() == load_criteria(["api_617", "iso_14839", "physics"])


def test_an_assessment_by_criteria_of_two_packs_with_one_name_is_refused(two_packs):
    """By default it uses all criteria, and would leave out both."""
    two_packs({"criteria/plant.toml": ""})
    with raises_naming(ValueError, "a and b", "criteria/plant.toml"):
        load_criteria()
    assert load_criteria(["api_617"])


def test_a_criteria_file_that_cannot_be_read_is_refused_with_its_pack(two_packs):
    """An assessment without it would be of other criteria than those that are installed."""
    for folder in two_packs({"criteria/plant_a.toml": "x = 1"})[1:]:
        (folder / "criteria" / "plant_a.toml").unlink()
    with raises_naming(ValueError, "criteria plant_a.toml", "pack a", "x"):
        load_criteria()
    assert load_criteria(["api_617"])
