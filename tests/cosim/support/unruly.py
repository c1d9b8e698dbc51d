"""An FMU that misbehaves in the step that its input `what` names."""

import os
import signal
import time

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

GOOD, CRASH, HANG, LEAVE, EAT, PRINT = range(6)


class Unruly(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.what, self.y = GOOD, 0.0
        self.register_variable(
            Integer("what", causality=Fmi2Causality.input, variability=Fmi2Variability.discrete, start=GOOD)
        )
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y = current_time + step_size
        if self.what == CRASH:
            os.kill(os.getpid(), signal.SIGSEGV)
        elif self.what == HANG:
            time.sleep(1000.0)
        elif self.what == LEAVE:
            os._exit(0)
        elif self.what == EAT:
            self.eaten = bytes(int(0.9 * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
        elif self.what == PRINT:
            os.write(1, b"a word among the answers\n")
        return True
