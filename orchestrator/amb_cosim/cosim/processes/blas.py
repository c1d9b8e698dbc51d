"""A single thread for linear algebra, so that its results do not depend on the number of processors.

The order in which libraries of linear algebra add numbers depends on the number of threads. This order affects the last
bits of results, and contact of the rotor amplifies such differences. The matrices are small, so threads would mostly
wait for each other.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit the loaded libraries of linear algebra (OpenBLAS, MKL, BLIS) to one thread within the block."""
    with _loaded_libraries(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _loaded_libraries(n_modules: int) -> Any:
    """Return the libraries that this process has loaded; finding them takes 2 ms, so they are found once.

    They are found again after an import, which changes `n_modules`, the number of modules.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
