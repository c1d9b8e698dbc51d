"""The process of a `SeparateComponent`: it calls one FMU instance as requested on its standard input."""

from __future__ import annotations

import os
import pickle
import sys
import time
from functools import partial
from typing import Any

from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.processes.child_process import limit_memory
from amb_cosim.cosim.processes.descendants import end_descendants, end_with_parent

POLL_TIME = 0.5  # s between checks that the parent still runs


def main() -> None:
    """Answer requests until there are no more; the first one loads the FMU."""
    parent = os.getppid()
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # keeps what FMUs print out of the answers
        request = pickle.load(sys.stdin.buffer)
        end_with_parent(partial(_wait_for_end_of, parent))  # standard input, which carries requests, cannot be awaited
        limit_memory()
        component: FmuComponent | None = None
        while True:
            reply: tuple[Exception | None, Any] = (None, None)
            try:
                if component is None:
                    component = FmuComponent(*request)
                else:
                    reply = (None, _answer(component, *pickle.load(sys.stdin.buffer)))
            except EOFError:
                break
            except Exception as error:
                reply = (error, None)
            pickle.dump(reply, answers)
            answers.flush()
            if component is None:
                break
    end_descendants(os.getpid())
    os._exit(0)  # FMUs may have threads, and code that runs when a process ends


def _answer(component: FmuComponent, method: str, arguments: tuple[Any, ...]) -> Any:
    """Set the inputs or the stop time if passed, call a method, and return its result (for `read`, the outputs)."""
    if method == "warnings":
        return component.warnings
    if method == "enter":
        *arguments, component.stop_time = arguments  # type: ignore[assignment]
    if method == "write":
        component.inputs[:], arguments = arguments[0], ()
    result = getattr(component, method)(*arguments)
    return component.outputs if method == "read" else result


def _wait_for_end_of(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(POLL_TIME)


if __name__ == "__main__":
    main()
