"""Writes a model's variable table, constants and fault sentences as C source for the native slave."""

from __future__ import annotations

import re
from collections.abc import Iterable

from fmi_export.model import Array, Model, Size
from fmi_export.variables import Variable

NUMBER = 32  # characters that a number in a sentence may take
PROSE = 512  # characters of the longest sentence of slave.c itself


def sizes_header(model: Model, constants: Array) -> str:
    """Return `sizes.h`, the sizes of all arrays."""
    table = model.interface
    sizes = {
        "N_PARAMETERS": table.n_parameters,
        "N_INPUTS": table.n_inputs,
        "N_OUTPUTS": table.n_outputs,
        "N_VALUES": len(table.variables),
        "N_STATE": _size(model.n_state, constants),
        "N_WORK": _size(model.n_work, constants),
        "N_CONSTANTS": len(constants),
        "N_FAULTS": len(model.faults),
        "TEXT_SIZE": PROSE + _longest_sentence(model),
    }
    return "".join(f"#define {name} {size}\n" for name, size in sizes.items())


def model_source(model: Model, constants: Array, guid: str) -> str:
    """Return `model.c`, the definitions that `model.h` declares.

    Raises
    ------
    ValueError
        If the sentence of a fault names an unknown variable.
    """
    variables = model.interface.variables
    parts = ['#include <stddef.h>\n#include "model.h"\n', f"const char model_guid[] = {_text(guid)};\n"]
    parts.append(_array("Variable variables[N_VALUES]", (_variable(v) for v in variables)))
    parts.append(_array("unsigned char types[N_VALUES]", (v.type.upper() for v in variables)))
    for name, values in (
        ("start_values", [v.start for v in variables]),
        ("minima", [v.minimum for v in variables]),
        ("maxima", [v.maximum for v in variables]),
    ):
        parts.append(_array(f"double {name}[N_VALUES]", (float(value).hex() for value in values)))
    parts.append(_array("double model_constants[N_CONSTANTS]", (float(value).hex() for value in constants)))
    for code, sentence in model.faults.items():
        parts.append("static " + _array(f"Piece sentence_{code}[]", _pieces(model, sentence)))
    rows = [f"{{{code}, sentence_{code}}}" for code in model.faults]
    parts.append(_array("FaultSentence fault_sentences[N_FAULTS + 1]", [*rows, "{0, NULL}"]))
    return "\n".join(parts)


def _size(size: Size, constants: Array) -> int:
    return max(size(constants) if callable(size) else size, 1)


def _variable(v: Variable) -> str:
    kind = f"{v.variability} {v.causality}"
    return f"{{{_text(v.name)}, {v.type.upper()}, {int(v.tunable)}, {_text(kind)}, {_text(_allowed(v))}}}"


def _allowed(v: Variable) -> str:
    """Return the part of `Variable.describe_range` after name and value."""
    return v.describe_range(0.0).removeprefix(f"{v.name} = 0")


def _pieces(model: Model, sentence: str) -> list[str]:
    rows = []
    for text, name in re.findall(r"([^{]*)(?:\{([^}]+)\})?", sentence):
        if name and name not in model.interface.position:
            raise ValueError(f"{model.name}: a fault's sentence names {name!r}, which is no variable: {sentence!r}")
        if text or name:
            rows.append(f"{{{_text(text)}, {model.interface.position[name] if name else -1}}}")
    return [*rows, "{NULL, -1}"]


def _longest_sentence(model: Model) -> int:
    ranges = [len(v.describe_range(0.0).encode()) + NUMBER for v in model.interface.variables]
    faults = [len(sentence.encode()) + NUMBER * sentence.count("{") for sentence in model.faults.values()]
    return max([*ranges, *faults])


def _array(declaration: str, rows: Iterable[str]) -> str:
    return f"const {declaration} = {{\n" + "".join(f"    {row},\n" for row in rows) + "};\n"


def _text(text: str) -> str:
    """Return a C string literal; special characters are written in octal."""
    plain = {ord(c) for c in map(chr, range(32, 127)) if c not in '"\\?'}
    return '"' + "".join(chr(byte) if byte in plain else f"\\{byte:03o}" for byte in text.encode()) + '"'
