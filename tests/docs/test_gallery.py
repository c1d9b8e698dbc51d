"""The pictures of the gallery are small, and `python -m tools.gallery` draws them."""

import re
from pathlib import Path

import pytest
from PIL import Image

from tools.gallery.__main__ import reduce
from tools.gallery.pictures import PICTURES, RUNS

DOCS = Path(__file__).parents[2] / "docs"


def test_every_picture_of_the_gallery_is_drawn_by_the_tool():
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", (DOCS / "gallery.md").read_text(encoding="utf-8"))
    assert {*shown} == {picture.file for picture in PICTURES.values()}
    assert {run for picture in PICTURES.values() for run in picture.needs} == {*RUNS}


@pytest.mark.parametrize("file", sorted({picture.file for picture in PICTURES.values()}))
def test_pictures_are_small(file):
    assert (DOCS / file).stat().st_size < (2_000_000 if file.endswith(".gif") else 200_000)


def test_reduced_picture_has_the_width_and_the_shape_of_the_drawing(tmp_path):
    Image.new("RGB", (800, 400), "#0072b2").save(tmp_path / "drawn.png")
    for width, expected in ((200, (200, 100)), (900, (800, 400))):
        reduce(tmp_path / "drawn.png", tmp_path / "small.png", width)
        with Image.open(tmp_path / "small.png") as small:
            assert small.size == expected
            assert small.convert("RGB").getpixel((5, 5)) == (0, 114, 178)
