"""Documentation in an FMU: page, sketch, licences, icon."""

import re
import zipfile

import numpy as np
import pytest
from lxml import etree
from rig import ACTUATOR, CONTROLLER

from amb_cosim.export import models
from amb_cosim.model_constants.plant_data import plant
from fmi_export.building import identity
from fmi_export.building.documentation import page

MODELS = {"amb_actuator": ACTUATOR, "rolac_controller": CONTROLLER, "rotor_contact": plant()[0]}


class Page:
    """Cells of tables by row, headings, and references to other files; a tag that is not closed is refused."""

    def __init__(self, text: str) -> None:
        root = etree.fromstring(re.sub(r"<((?:img|meta|br|hr)\b[^>]*?)/?>", r"<\1/>", text))
        self.text = " ".join(root.itertext())
        self.rows = [["".join(cell.itertext()) for cell in row] for row in root.iter("tr")]
        self.headings = ["".join(heading.itertext()) for heading in root.iter("h1", "h2", "h3")]
        self.references = root.xpath("//@src | //@href")


@pytest.fixture(scope="module")
def archive(build_fmu):
    with zipfile.ZipFile(build_fmu(ACTUATOR)) as opened:
        yield opened


def test_an_fmu_has_a_page_a_sketch_licences_and_an_icon(archive):
    held = {name for name in archive.namelist() if name.startswith(("documentation/", "model.png"))}
    pages = {"documentation/index.html", "documentation/sketch.svg"}
    held.discard("documentation/fmi-ls-ref.txt")  # where an engine is at hand
    assert held == pages | {f"documentation/licenses/{name}.txt" for name in ("license", "pythonfmu")} | {"model.png"}
    own, other = (archive.read(f"documentation/licenses/{name}.txt").decode() for name in ("license", "pythonfmu"))
    assert "Redistribution and use in source and binary forms" in own
    assert "Copyright" in other


@pytest.mark.parametrize("name", MODELS)
def test_the_page_shows_the_variables_and_loads_no_other_file(name):
    model = MODELS[name]
    shown = Page(page(model))
    assert shown.headings[0] == name
    variables = {row[0]: row for row in shown.rows if row[0] in model.interface.position and len(row) == 6}
    assert list(variables) == list(model.interface.position)
    for v in model.interface.variables:
        assert v.description in variables[v.name][-1]
    assert [reference for reference in shown.references if not reference.startswith("https:")] == ["./sketch.svg"]


@pytest.mark.parametrize("name", MODELS)
def test_pages_of_another_machine_name_no_parts_of_the_rig(name):
    model, _ = getattr(models, name)(rotor="turbo_expander")
    other, rig = Page(page(model)), Page(page(MODELS[name]))
    assert re.findall(r"(?i)(?<!/)\b(?:mb[12]|rb[12]|eb[12]|d[1-4]|s[1-8])\b", other.text) == []
    assert "Run it" in set(rig.headings) - set(other.headings)


def test_a_model_without_a_readme_has_a_page_too(lag):
    shown = Page(page(lag))
    assert shown.headings[:2] == [lag.name, "Parameters"]
    assert [row[0] for row in shown.rows if row[0] in lag.interface.position][: len(lag.interface.variables)] == [
        *lag.interface.position
    ]


def test_a_changed_page_or_picture_changes_the_guid(tmp_path, monkeypatch):
    (tmp_path / "documentation").mkdir()
    find = identity.package_folder
    monkeypatch.setattr(identity, "package_folder", lambda name: tmp_path if name == "amb_actuator" else find(name))
    monkeypatch.setattr(identity, "digests", lambda _: {})
    guids = [identity.guid_of(ACTUATOR, np.zeros(1))]
    for file in ("README.md", "documentation/icon.png", "documentation/sketch.svg"):
        (tmp_path / file).write_text(file)
        guids.append(identity.guid_of(ACTUATOR, np.zeros(1)))
    assert len(set(guids)) == 4
