"""Settings under which BLAS, numpy, numba and the C library choose the instructions of other processors.

The order of sums, and fused operations, change last bits from one processor to another. Each setting has empty caches,
since code compiled for one processor is not valid for another.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import platformdirs

OLD_LEVELS = "X86_V3 X86_V4 AVX2 FMA3 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR"
NO_AVX512 = "X86_V4 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR"
# By name: processors for OpenBLAS and numba, and instruction sets that numpy and the C library must not use.
SETTINGS: Mapping[str, Mapping[str, str]] = {
    "own": {},
    "oldest": {
        "OPENBLAS_CORETYPE": "Prescott",
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NPY_DISABLE_CPU_FEATURES": OLD_LEVELS,
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F",
    },
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell", "NUMBA_CPU_NAME": "haswell", "NPY_DISABLE_CPU_FEATURES": NO_AVX512},
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX", "NUMBA_CPU_NAME": "skylake-avx512"},
    "Zen": {"OPENBLAS_CORETYPE": "Zen", "NUMBA_CPU_NAME": "znver2", "NPY_DISABLE_CPU_FEATURES": NO_AVX512},
}
NEEDS = {"Haswell": "avx2", "Zen": "avx2", "SkylakeX": "avx512f"}  # flags of the processor

# Products, decompositions, sums and functions of numpy, and functions of the C library, as one number to compare.
DIGEST = """
import hashlib, math
import numpy as np
import platformdirs
x = np.linspace(0.0, 50.0, 20001)
A = np.outer(np.cos(x[:60]), x[:60]) + np.sin(7.0 * np.outer(x[:60], x[60:120]))
found = [A @ A, np.linalg.eigvals(A), A.sum(0), A.sum(1), np.sin(x), np.exp(-x), np.sqrt(x)]
found += [np.array([f(v) for v in x]) for f in (math.sin, math.cos, math.exp)]
print(hashlib.sha256(b"".join(array.tobytes() for array in found)).hexdigest())
"""


def chosen_settings(parser: argparse.ArgumentParser, arguments: list[str]) -> tuple[list[str], argparse.Namespace]:
    """Return the names of the settings to use, all by default, and the other arguments; print the settings left out.

    Settings are left out if this processor cannot run them, or if they give the same bits as an earlier one.
    """
    parser.add_argument("settings", nargs="*", metavar="SETTING", help=f"of {', '.join(SETTINGS)}; all by default")
    values = parser.parse_args(arguments)
    unknown = set(values.settings) - set(SETTINGS)
    if unknown:
        parser.error(f"there is no setting {', '.join(sorted(unknown))}; there are {', '.join(SETTINGS)}")
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").split() if sys.platform == "linux" else []
    names: dict[str, str] = {}
    for name in values.settings or SETTINGS:
        if NEEDS.get(name) not in (None, *flags):
            print(f"{name}: left out, this processor has no {NEEDS[name]}")
            continue
        with environment_of(name) as environment:
            digest = subprocess.run(
                [sys.executable, "-c", DIGEST], env=environment, check=True, capture_output=True, text=True
            ).stdout
        if digest in names:
            print(f"{name}: left out, on this processor it gives the same bits as {names[digest]}")
        else:
            names[digest] = name
    return list(names.values()), values


@contextmanager
def environment_of(name: str) -> Iterator[dict[str, str]]:
    """Yield the environment of processes under a setting, with caches that are empty at first."""
    changes = dict(SETTINGS[name])
    if "NPY_DISABLE_CPU_FEATURES" in changes:  # numpy refuses unknown names
        available = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
        levels = changes["NPY_DISABLE_CPU_FEATURES"].split()
        changes["NPY_DISABLE_CPU_FEATURES"] = " ".join(level for level in levels if level in available)
    # Without byte code in the new folder, every process would compile all that it imports.
    dropped = {"PYTHONDONTWRITEBYTECODE", "AMB_COSIM_TEST_CACHE"}.union(*SETTINGS.values())
    inherited = {key: value for key, value in os.environ.items() if key not in dropped}
    with tempfile.TemporaryDirectory() as folder:
        caches = {
            "NUMBA_CACHE_DIR": str(Path(folder, "numba")),
            "PYTHONPYCACHEPREFIX": str(Path(folder, "pycache")),
            "XDG_CACHE_HOME": str(Path(folder, "cache")),
            # The cache of the C compiler does not depend on the setting.
            "ZIG_GLOBAL_CACHE_DIR": os.environ.get("ZIG_GLOBAL_CACHE_DIR", platformdirs.user_cache_dir("zig")),
        }
        yield inherited | changes | caches
