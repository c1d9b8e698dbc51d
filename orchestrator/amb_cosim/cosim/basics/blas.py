"""A single thread for linear algebra, so that its results do not depend on the number of processors.

Libraries of linear algebra sum in an order that depends on the number of threads, which changes last bits; landings in
contact amplify them. The matrices are small, so threads would mostly wait for each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit the loaded libraries of linear algebra (OpenBLAS, MKL, BLIS) to one thread within the block."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, user_api="blas"):
        yield
