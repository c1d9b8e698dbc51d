"""Theory pages name the code they are about; pages of the FMUs are short, and their links lead somewhere."""

import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))
MODELS = ("rotor_contact", "amb_actuator", "rolac_controller", "linear_controller", "levitated_rotor")
LISTING = {
    "rotor_analysis": ROOT / "libraries/rotor_analysis",
    "amb_cosim.model_constants": ROOT / "orchestrator/amb_cosim/model_constants",
}
FMU_PAGES = [ROOT / "fmus" / name / "README.md" for name in MODELS]
DECLARING = {"__init__", "interface", "records", "signals"}  # tables and records, which every model has


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", MODELS)
def test_every_file_of_a_model_is_named_on_a_theory_page(name):
    named = set(re.findall(r"`(?:[a-z_]+\.)*([a-z_]+)(?:\.py)?`", " ".join(text_of(page) for page in THEORY)))
    files = {file.stem for file in Path(import_module(name).__file__).parent.rglob("*.py")}
    assert files - DECLARING - {f"{name}_fmu"} - named == set()


@pytest.mark.parametrize("package", LISTING)
def test_the_readme_of_a_package_names_each_file(package):
    folder = Path(import_module(package).__file__).parent
    files = {file.name for pattern in ("*.py", "*.toml") for file in folder.glob(pattern)} - {"__init__.py"}
    assert {name for name in files if f"`{name}`" not in text_of(LISTING[package] / "README.md")} == set()


READMES = [folder / "README.md" for folder in LISTING.values()]


@pytest.mark.parametrize("page", [*THEORY, *FMU_PAGES, *READMES], ids=lambda page: f"{page.parent.name}/{page.stem}")
def test_links_and_pictures_of_a_page_lead_to_files(page):
    links = re.findall(r"\]\((?!https?:|#)([^)#\s]+)", text_of(page))
    assert [link for link in links if not (page.parent / link).is_file()] == []
