"""Studies called from Python compute with one thread of linear algebra, as their commands do."""

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from amb_analysis import studies


def threads():
    """A study that computes, and returns the numbers of threads of the libraries of linear algebra."""
    assert np.linalg.det(np.eye(2)) == 1.0
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_a_study_called_from_python_computes_with_one_thread(monkeypatch):
    monkeypatch.setitem(studies._GENERAL, "threads", studies.Study(__name__, "Count threads."))
    with threadpool_limits(2, user_api="blas"):
        assert studies.threads() == {1}
        assert threads() == {2}
