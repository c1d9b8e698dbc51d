"""Starts the command line; even during imports, Ctrl-C and SIGTERM end it with a single line and an exit code."""

import os
import signal
import sys
from contextlib import chdir
from pathlib import Path

if "multiprocessing.spawn" in sys.modules:  # a process of a sweep or a study, which imports the script that started it
    from amb_cosim.cosim.processes.descendants import continue_without_parent

    continue_without_parent()  # before the rest is imported, which takes seconds

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}


def main() -> None:
    """Import and run the command line."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small: threads would wait for each other
    os.environ["MPLBACKEND"] = "agg"  # commands draw files; that of a notebook may not be installed here
    os.environ["MATPLOTLIBRC"] = os.devnull  # no setting of it applies, and matplotlib ends if it cannot be read
    for number in CODES:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)
    if os.path.lexists("matplotlibrc"):  # matplotlib reads that of the working folder first, even from a pipe
        with chdir(Path(__file__).parent):
            import matplotlib  # noqa: F401
    from amb_cosim.commands.cli import main

    try:
        main(prog_name="amb-cosim")
    except SystemExit as ended:
        if ended.code in CODES.values():  # the message is printed; hide those about half-made objects
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        raise


def _end(number: int, _: object) -> None:
    """End the process at once, because some imports would lose an exception, and others would display its traceback."""
    os.write(2, b"amb-cosim: interrupted\n")
    os._exit(CODES[signal.Signals(number)])
