"""The C code of an FMU, for targets without a shipped library; any C99 compiler can build it.

The folder `sources` contains the code of the engine, with the kernels translated to C (`c99`). A library that is
compiled from this code uses the same resources and gives the same FMU. Function names begin with the model identifier,
as FMI requires for source code, so that FMUs of several models can be linked into one program. To build a shared
library, define FMI2_OVERRIDE_FUNCTION_PREFIX or FMI3_OVERRIDE_FUNCTION_PREFIX.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Literal
from xml.etree.ElementTree import Element, SubElement

from fmi_export.building.description import xml_file
from fmi_export.building.native.c99.translation import HEADER, to_c
from fmi_export.building.native.engines import SLAVE, SLAVE3, key_header, lowered_kernels
from fmi_export.building.native.sources import texts_of
from fmi_export.model import Model

NAMES = "names.h"  # which every file begins with
DECLARED = re.compile(r"^(?!static|typedef)(?:\w+ )+\**(\w+)\((?=[^;{]*;)", re.MULTILINE)  # functions in a header
COMPILER = "gcc"
OPTIONS = "-std=c99 -ffp-contract=off"  # of GCC and Clang: a product and a sum are rounded apart on every processor


def portable_sources(model: Model, fmi: Literal[2, 3]) -> dict[str, str]:
    """Return the texts of the C files and headers of a model's FMU, by the names of the files.

    Raises
    ------
    ValueError
        If the kernels must be lowered but numba is missing, or if they contain code without a counterpart in C.
    """
    if fmi == 3:
        files = [name for name in (*SLAVE, *SLAVE3) if "fmi2" not in name]
    else:
        files = list(SLAVE)
    local = texts_of([*files, "compiled.c"])
    kernels = {f"{m.name}.c": to_c(lowered_kernels(m)) for m in model.compiled}
    entries = [f"{m.name}_{entry}" for m in model.compiled for entry in ("initialise", "step")]
    code = {name: f'#include "{NAMES}"\n\n{text}' for name, text in (local | kernels).items() if name.endswith(".c")}
    headers = {name: text for name, text in local.items() if name.endswith(".h")}
    names = {NAMES: _names(model.name, fmi, [*_functions(headers), *entries])}
    return code | headers | key_header(model.compiled) | texts_of([f"c99/{HEADER}"]) | names


def compiled_files(code: Iterable[str]) -> list[str]:
    """Return the names of the files to compile."""
    return sorted(name for name in code if name.endswith(".c"))


def build_description(model: Model, code: Iterable[str]) -> bytes:
    """Return buildDescription.xml, which contains the build instructions of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model.name)
    files = SubElement(configuration, "SourceFileSet", language="C99", compiler=COMPILER, compilerOptions=OPTIONS)
    for name in compiled_files(code):
        SubElement(files, "SourceFile", name=name)
    SubElement(
        files,
        "PreprocessorDefinition",
        name="FMI3_OVERRIDE_FUNCTION_PREFIX",
        optional="true",
        value="",
        description="For a shared library: do not prefix names of functions with the model identifier",
    )
    SubElement(configuration, "Library", name="m", external="true", description="C's mathematical library")
    return xml_file(root)


def _functions(headers: dict[str, str]) -> list[str]:
    """Return the names of the functions that files of the slave share."""
    return sorted({f for name, text in headers.items() if not name.startswith("fmi") for f in DECLARED.findall(text)})


def _names(model: str, fmi: Literal[2, 3], functions: Iterable[str]) -> str:
    prefix = f"FMI{fmi}_FUNCTION_PREFIX"
    renamed = "".join(f"#define {name} {model}_own_{name}\n" for name in functions)
    return (
        f"/* Names that begin with the model identifier, so that one program can contain several FMUs. For a shared\n"
        f"   library, whose functions have plain FMI names, define FMI{fmi}_OVERRIDE_FUNCTION_PREFIX. */\n\n"
        f"#ifndef AMB_NAMES_H\n#define AMB_NAMES_H\n\n"
        f"#if !defined {prefix} && !defined FMI{fmi}_OVERRIDE_FUNCTION_PREFIX\n#define {prefix} {model}_\n#endif\n\n"
        f"{renamed}\n#endif\n"
    )
