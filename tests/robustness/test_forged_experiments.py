"""FMUs whose reference experiments have random mistakes: `verify` says equal where they are, and why not elsewhere."""

from __future__ import annotations

import csv
import importlib
import io
import random
import re
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from commands import run
from mutations import NUMBERS, TEXTS, changed_text

from fmi_export.model import with_starts

pytestmark = pytest.mark.slow

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
FILES = (*4 * ("references.csv",), *2 * ("smoke_test.exp",), "fmi-ls-manifest.xml")
CELLS = (*NUMBERS, "", " ", "true", "0.5 0.5", "1e-3", "0,5", "\u0661")
TIMES = ("0.0025", "0.0031", "-1", "0", "1e-12", "1e300")
EQUAL = re.compile(r".*: equal (?:to the last bit|within (\S+)).*, [1-9]\d* values at [1-9]\d* points.*")
TIME = 60.0  # s, of a command; a forged experiment may have a million steps


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The files of a lag's FMU that moves, by name."""
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")
    from fmi_export.building.native.package import build_native_fmu

    model = with_starts(importlib.import_module("probe_lag.lag").MODEL, {"u": 1.0})
    with zipfile.ZipFile(build_native_fmu(model, np.zeros(1), tmp_path_factory.mktemp("lag"))) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def forged_table(text, chance):
    """A table with cells, names, columns or rows changed, taken away, doubled or exchanged."""
    rows = list(csv.reader(text.splitlines()))
    for _ in range(chance.randint(1, 3)):
        i, j, k = chance.randrange(len(rows)), chance.randrange(len(rows[0])), chance.randrange(len(rows[0]))
        kind = chance.randrange(8)
        if kind < 3 and i:
            rows[i][j] = chance.choice(CELLS if chance.random() < 0.7 or j else TIMES)
        elif kind == 3 and i:
            rows[i][j] = (
                repr(float(rows[i][j] or 0.0) * (1.0 + 10 ** chance.uniform(-16, 1))) if _is_number(rows[i][j]) else ""
            )
        elif kind == 4:
            rows[0][j] = chance.choice((*rows[0], *TEXTS))
        elif kind == 5 and len(rows[0]) > 1:
            rows = [row[:j] + row[j + 1 :] for row in rows]
        elif kind == 6:
            rows = [[*row, row[k]] for row in rows]
        elif kind == 7 and len(rows) > 2:
            rows.insert(i, rows.pop(chance.randrange(len(rows))) if chance.random() < 0.5 else list(rows[i]))
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows(rows)
    return written.getvalue()


def forged(text, name, chance):
    if name.endswith(".csv") and chance.random() < 0.8:
        return forged_table(text, chance)
    if name.endswith(".exp") and chance.random() < 0.5:
        key = chance.choice(("stopTime", "startTime", "stepSize", "tolerance", "name", "source"))
        value = chance.choice((*NUMBERS, *TIMES, "a&#10;smoke_test: equal", "references.csv"))
        text = re.sub(f' {key}="[^"]*"', f' {key}="{value}"', text, count=1)
        return text.replace("<Experiment ", f'<Experiment tolerance="{chance.choice(NUMBERS)}" ', 1)
    return changed_text(text, chance)


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def wrong_cells(text, expected):
    """What is wrong in a table that was said to be equal to `expected`, read without the reader under test."""
    rows = list(csv.reader(text.splitlines()))
    names = [name.strip() for name in rows[0]]
    if len(names) != len(set(names)) or len(names) < 2 or len(rows) < 2:
        return "columns twice, or none"
    wrong = []
    times = [float(row[names.index("time")]) for row in rows[1:]]
    grid = np.array([float(t) for t in expected["time"]])
    for k, name in enumerate(names):
        if name == "time":
            continue
        true = np.array([float(value) for value in expected[name]])
        scale = max(abs(true).max(), 1e-300)
        for time, row in zip(times, rows[1:], strict=True):
            value = float({"true": "1", "false": "0"}.get(row[k].strip().lower(), row[k]))
            between = grid[np.searchsorted(grid, time - 1e-12) - 1 :][:3]
            allowed = 1.1e-6 if np.abs(grid - time).min() < 1e-9 else 0.1
            if not (len(between) and abs(value - np.interp(time, grid, true)) <= allowed * max(scale, abs(value))):
                wrong.append((name, time, value))
    return wrong


@pytest.fixture
def here(monkeypatch):
    """Forks of this process verify in themselves: a process that imports what it needs takes a second."""
    from amb_cosim.cosim.basics.cache import unpacked
    from amb_cosim.cosim.verify import verification, verification_process

    def verify(fmu):
        folder, _ = unpacked(Path(fmu), f"FMU {fmu}")
        try:
            experiments = verification_process.read_experiments(folder)
            return [verification_process._verified(folder, item) for item in experiments]
        except Exception as error:
            raise ValueError(verification._printable(f"{fmu}: {error}")) from error

    monkeypatch.setattr(verification, "verify", verify)


def test_forged_experiments_are_not_said_to_be_equal(here, whole, tmp_path, first_seed, rounds):
    """Where the references alone were forged, values of those that pass are compared with the true ones again."""
    expected = {name: [] for name in csv.DictReader(whole[f"{FOLDER}/references.csv"].decode().splitlines()).fieldnames}
    for row in csv.DictReader(whole[f"{FOLDER}/references.csv"].decode().splitlines()):
        for name, value in row.items():
            expected[name].append(value)
    mistakes, codes = [], []
    for seed in range(first_seed, first_seed + rounds):
        chance = random.Random(seed)
        name = chance.choice(FILES)
        text = forged(whole[f"{FOLDER}/{name}"].decode(), name, chance)
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for entry, content in (whole | {f"{FOLDER}/{name}": text.encode()}).items():
                archive.writestr(entry, content)
        ended = run(["verify", "mine.fmu"], tmp_path / str(seed), {"mine.fmu": packed.getvalue()}, TIME)
        codes.append(ended.code)
        mistake = None if ended.code == 1 and "not" in ended.output.lower() else ended.mistake()
        if ended.code == 0:
            lines = ended.output.strip().splitlines()
            said = [EQUAL.fullmatch(line) for line in lines]
            if not all(match and float(match[1] or 0.0) <= 1e-3 for match in said) or len({*lines}) > 1:
                mistake = f"it says {lines}"
            elif name == "references.csv" and (wrong := wrong_cells(text, expected)):
                mistake = f"equal, and {wrong}"
        if mistake:
            mistakes.append(
                f"seed {seed}, {name}: {mistake}\n{text[:1500]}\n{ended.output[-500:]}{ended.errors[-1500:]}"
            )
        shutil.rmtree(tmp_path / str(seed))
    print({code: codes.count(code) for code in sorted(set(codes))})
    assert not mistakes, f"{len(mistakes)} of {len(codes)}:\n" + "\n".join(mistakes)
    assert {0, 1, 2} <= set(codes)
