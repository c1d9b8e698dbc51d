"""The C files of an engine are in layers: a file and its header use only those below."""

import re
from graphlib import TopologicalSorter

from fmi_export.building.native.sources import FOLDER

INCLUDED = re.compile(r'^#include "(\w+)\.h"', re.MULTILINE)
DECLARED = re.compile(r"^(?!static|typedef)\w[\w *]*?\b(\w+)\([^;{]*\);", re.MULTILINE)
OF_SEVERAL = {"kernels": "compiled"}  # the other file is for flavour python


def texts(suffix):
    return {file.stem: file.read_text(encoding="utf-8") for file in FOLDER.glob(f"*.{suffix}")}


def test_c_files_and_their_headers_use_each_other_without_circles():
    uses = {}
    for stem, text in (*texts("c").items(), *texts("h").items()):
        uses.setdefault(stem, set()).update(set(INCLUDED.findall(text)) - {stem})
    assert {"host", "saved", "assembly"} <= uses["slave"]
    order = [*TopologicalSorter(uses).static_order()]
    assert order.index("instance") < order.index("assembly") < order.index("slave") < order.index("fmi2")


def test_each_function_is_in_the_c_file_of_the_header_that_declares_it():
    codes = texts("c")
    for stem, text in texts("h").items():
        for name in DECLARED.findall(text):
            assert re.search(rf"^\w[\w *]*\b{name}\(", codes[OF_SEVERAL.get(stem, stem)], re.MULTILINE), (stem, name)
