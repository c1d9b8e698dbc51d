"""The process that `isolation` starts: it reads a plan from standard input, runs it, and answers on standard output."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from dataclasses import replace
from typing import Any

from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.processes.child_process import limit_memory
from amb_cosim.cosim.processes.descendants import end_descendants, end_with_parent
from amb_cosim.cosim.run.execution import run_here
from amb_cosim.cosim.run.isolation import ERROR, PROGRESS, RECORDING


def main() -> None:
    """Send progress, and the recording or the error of `run_here`."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # keeps what FMUs print out of the answers
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # a run defers it to a safe moment
        plan, options = pickle.load(sys.stdin.buffer)
        end_with_parent(sys.stdin.buffer.read)
        memory = limit_memory()

        def answer(kind: int, *content: Any) -> None:
            pickle.dump((kind, *content), answers)
            answers.flush()

        instances = InstancePool()
        options = replace(options, instances=instances, progress=lambda *steps: answer(PROGRESS, *steps))
        try:
            recording = run_here(plan, options)
            answer(RECORDING, recording)
            instances.close()  # after the record is sent, which a crash on closing would lose
        except MemoryError:
            answer(
                ERROR, ProcessFailed(f"the FMUs need more memory than {memory / 2**30:.1f} GB; nothing was recorded")
            )
        except Exception as error:
            answer(ERROR, error)
        except KeyboardInterrupt:
            pass  # before anything was recorded
    end_descendants(os.getpid())
    os._exit(0)  # FMUs may have threads, and code that runs when a process ends


if __name__ == "__main__":
    main()
