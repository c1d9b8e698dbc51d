"""The process of a `SeparateComponent`: it calls one FMU instance as requests on its standard input say."""

from __future__ import annotations

import os
import pickle
import sys
import time
from functools import partial
from typing import Any

from amb_cosim.cosim.basics.child_process import limit_memory
from amb_cosim.cosim.basics.descendants import end_descendants, end_with_parent
from amb_cosim.cosim.fmu.component import FmuComponent, HeldState

POLL_TIME = 0.5  # s between two looks at whether the parent is still there


class _Server:
    """An FMU instance, and the states that it holds, by number."""

    def __init__(self, arguments: tuple[Any, ...]) -> None:
        self.component = FmuComponent(*arguments)
        self.held: dict[int, HeldState] = {}

    def answer(self, method: str, arguments: tuple[Any, ...]) -> Any:
        """Call a method, and return its result."""
        component = self.component
        if method == "enter":
            start_time, component.stop_time = arguments
            return component.enter(start_time)
        if method == "write":
            component.inputs[:] = arguments[0]
            return component.write()
        if method == "warnings":
            return component.warnings
        if method == "hold":
            number = max(self.held, default=0) + 1
            self.held[number] = component.hold()
            return number
        if method == "forget":
            return component.forget(self.held.pop(arguments[0]))
        if method == "put":
            state, warnings = arguments
            return component.put(self.held[state] if isinstance(state, int) else state, warnings)
        result = getattr(component, method)(*arguments)
        return component.outputs if method == "read" else result


def main() -> None:
    """Answer requests until there are no more."""
    parent = os.getppid()
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # what FMUs print does not go among the answers
        arguments = pickle.load(sys.stdin.buffer)
        end_with_parent(partial(_wait_for_end_of, parent))  # standard input has requests
        limit_memory()
        server: _Server | None = None
        while True:
            try:
                if server is None:
                    server, answer = _Server(arguments), None
                else:
                    method, arguments = pickle.load(sys.stdin.buffer)
                    answer = server.answer(method, arguments)
                reply: tuple[Exception | None, Any] = (None, answer)
            except EOFError:
                break
            except Exception as error:
                reply = (error, None)
            pickle.dump(reply, answers)
            answers.flush()
            if server is None:
                break
    end_descendants(os.getpid())
    os._exit(0)  # FMUs may have threads, and code that runs when a process ends


def _wait_for_end_of(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(POLL_TIME)


if __name__ == "__main__":
    main()
