"""Steps the actuator with a cache of kernels that is damaged anew each time: `damaged_kernels.py FOLDER SEED ROUNDS`.

Each round is a fork of this process, which has loaded numba and none of the kernels. The last line that it prints is a
list of what went wrong, in JSON.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import sys
from pathlib import Path

import numba
import numpy as np
from damage import damaged

ENTRIES = ("actuator.initialise-", "actuator.step-", "model.")  # what Python calls, and so is loaded


def stepped(answer: Path) -> None:
    """Write all values of an actuator after some steps to a file."""
    from amb_cosim.cosim.fmu.fmus import model_source
    from fmi_export.model import Instance

    instance = Instance(*model_source("amb_actuator"))
    instance["mb1.i_x"] = 0.7
    instance.initialise()
    for n in range(20):
        instance.step(n * 1e-3, 1e-3)
    answer.write_bytes(instance.values.tobytes())


def in_a_fork(cache: Path, answer: Path) -> int:
    """Return how a process ended that steps with this cache."""
    process = os.fork()
    if process == 0:
        numba.config.CACHE_DIR = str(cache)
        code = 1
        try:
            stepped(answer)
            code = 0
        except BaseException:
            import traceback

            traceback.print_exc()
        os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def main() -> None:
    folder, first_seed, rounds = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    whole, cache, answer = folder / "whole", folder / "cache", folder / "answer"
    assert in_a_fork(whole, answer) == 0
    expected, wrong = answer.read_bytes(), []
    assert np.isfinite(np.frombuffer(expected)).all()
    for seed in range(first_seed, first_seed + rounds):
        chance = random.Random(seed)
        shutil.rmtree(cache, ignore_errors=True)
        shutil.copytree(whole, cache)
        files = sorted(path for path in cache.rglob("*.nb?") if path.name.startswith(ENTRIES))
        path = chance.choice(files)
        path.write_bytes(damaged(path.read_bytes(), chance))
        answer.unlink()
        code = in_a_fork(cache, answer)
        if code != 0 or answer.read_bytes() != expected:
            wrong.append(f"seed {seed}, {path.name}: " + (f"ended with {code}" if code else "other values"))
            answer.touch()
    sys.stdout.write(json.dumps(wrong) + "\n")


if __name__ == "__main__":
    main()
