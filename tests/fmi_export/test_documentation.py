"""What an FMU holds for people: page, sketch, licences, icon."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
import zipfile
from html.parser import HTMLParser
from importlib.util import find_spec

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from rig import ACTUATOR, ACTUATOR_CONSTANTS, CONTROLLER, NO_TABLE

from amb_cosim.design.plant_data import plant
from fmi_export.building import documentation, identity
from fmi_export.building.documentation import page

PLANT, PLANT_CONSTANTS = plant()
MODELS = {"amb_actuator": ACTUATOR, "rolac_controller": CONTROLLER, "rotor_contact": PLANT}
CONSTANTS = {"amb_actuator": ACTUATOR_CONSTANTS, "rolac_controller": NO_TABLE, "rotor_contact": PLANT_CONSTANTS}
WITHOUT_END = {"img", "meta", "br", "hr"}


class Page(HTMLParser):
    """Cells of tables by row, headings, references to other files, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows: list[list[str]] = []
        self.references: list[str] = []
        self.headings: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in WITHOUT_END:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")
        elif tag in ("h1", "h2", "h3"):
            self.headings.append("")
        self.references += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert tag in WITHOUT_END or self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data
        elif self.open and self.open[-1] in ("h1", "h2", "h3"):
            self.headings[-1] += data


@pytest.fixture(scope="module")
def archive(build_fmu):
    with zipfile.ZipFile(build_fmu(ACTUATOR)) as opened:
        yield opened


def test_an_fmu_has_a_page_a_sketch_licences_and_an_icon(archive):
    held = {name for name in archive.namelist() if name.startswith(("documentation/", "model.png"))}
    pages = {"documentation/index.html", "documentation/sketch.svg"}
    assert held == pages | {f"documentation/licenses/{name}.txt" for name in ("license", "pythonfmu")} | {"model.png"}
    own, other = (archive.read(f"documentation/licenses/{name}.txt").decode() for name in ("license", "pythonfmu"))
    assert "Redistribution and use in source and binary forms" in own
    assert "Copyright" in other


@pytest.mark.parametrize("name", MODELS)
def test_the_icon_is_a_picture_of_a_hundred_pixels(name):
    icon = documentation.documentation(MODELS[name])["model.png"]
    assert icon[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", icon[16:24]) == (100, 100)
    assert len(icon) < 8000


@pytest.mark.parametrize("name", MODELS)
def test_the_page_shows_the_variables_of_the_fmu_and_needs_nothing_else(name):
    model = MODELS[name]
    shown = Page(page(model))
    assert shown.headings[0] == name
    variables = {row[0]: row for row in shown.rows if row[0] in model.interface.position and len(row) == 6}
    assert list(variables) == list(model.interface.position)
    for v in model.interface.variables:
        assert v.description in variables[v.name][-1]
    assert [reference for reference in shown.references if not reference.startswith("https:")] == ["./sketch.svg"]


@pytest.mark.parametrize("name", MODELS)
def test_the_page_has_all_faults_and_warnings(name):
    model = MODELS[name]
    rows = {row[0]: row[1:] for row in Page(page(model)).rows}
    for code, sentence in model.faults.items():
        assert rows[str(code)] == [re.sub(r"[{}]", "", sentence)]
    for v in model.interface.of("output"):
        assert not v.warning or rows[v.name] == [re.sub(r"[{}]", "", v.warning)]


def test_a_model_without_a_readme_has_a_page_too(lag):
    shown = Page(page(lag))
    assert shown.headings[:2] == [lag.name, "Parameters"]
    assert [row[0] for row in shown.rows if row[0] in lag.interface.position][: len(lag.interface.variables)] == [
        *lag.interface.position
    ]


def test_another_page_or_picture_is_another_guid(tmp_path, monkeypatch):
    (tmp_path / "documentation").mkdir()
    find = identity.package_folder
    monkeypatch.setattr(identity, "package_folder", lambda name: tmp_path if name == "amb_actuator" else find(name))
    monkeypatch.setattr(identity, "digests", lambda _: {})
    guids = [identity.guid_of(ACTUATOR, np.zeros(1))]
    for file in ("README.md", "documentation/icon.png", "documentation/sketch.svg"):
        (tmp_path / file).write_text(file)
        guids.append(identity.guid_of(ACTUATOR, np.zeros(1)))
    assert len(set(guids)) == 4


@pytest.mark.slow
@pytest.mark.skipif(find_spec("fmu_manipulation_toolbox") is None, reason="fmutool is not installed (extra: peers)")
@pytest.mark.parametrize("name", MODELS)
def test_fmutool_and_fmpy_find_no_problem(name, build_fmu):
    fmu = build_fmu(MODELS[name], CONSTANTS[name])
    program = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    command = [sys.executable, "-c", program, "-input", str(fmu), "-check"]
    checked = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    text = checked.stdout + checked.stderr
    assert "compliant with FMI-2.0" in text, text
    assert "No semantic error" in text, text
    assert not re.search(r"\b(ERROR|WARNING)\b", text), text
    assert validate_fmu(str(fmu)) == []
