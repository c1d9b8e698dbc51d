"""Ctrl-C and SIGTERM in a run with slow steps: a contact that is nearly too stiff to integrate."""

import os
import signal
import subprocess
import sys
import time

import pytest
from command_line import COMMAND
from waiting import let_compute, of_process, processor_time

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="processes are watched in /proc")]

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}
LONGEST = 1.0  # s of the processor's time from a signal to the end of the process

RUN = ("simulate", "stiff.toml", "-o", "out")
# Thirty seconds without contact take a moment, and the loop rarely returns to Python. Then a step takes about 10 ms.
STIFF = """
base = "passive"
[parameters.rotor_contact]
"rb?.law" = "hunt_crossley"
"rb?.alpha_c" = 1000
"rb?.k_c" = 1e9
"rb?.delta_c" = 1e-9
[experiment]
communication_step = "0.25 ms"
stop_time = "10000 s"
record.variables = ["rotor_contact.rb1.f_n"]
record.every = 100
[[experiment.event]]
time = "30 s"
set = { "rotor_contact.d1.f_x" = "100 kN" }
"""


def has_loaded(process):
    return "rotor_contact" in of_process(process.pid, "maps")


@pytest.mark.parametrize("options", [[], ["--loop", "plain"], ["--flavour", "python"]], ids=" ".join)
@pytest.mark.parametrize("number", CODES)
def test_signal_ends_a_run_within_a_second_of_slow_steps(tmp_path, number, options):
    (tmp_path / "stiff.toml").write_text(STIFF)
    with subprocess.Popen(
        [*COMMAND, *RUN, *options], cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        try:
            while not has_loaded(process):
                time.sleep(0.02)
            let_compute(process, processor_time(process.pid) + 5.0)
            before = processor_time(process.pid)
            process.send_signal(number)
            _, status, usage = os.wait4(process.pid, 0)
        finally:
            process.kill()
        errors = process.stderr.read()
    assert os.waitstatus_to_exitcode(status) == CODES[number], errors
    assert usage.ru_utime + usage.ru_stime - before < LONGEST
    assert errors.splitlines()[-1].startswith("amb-cosim: interrupted at t = 30.")
