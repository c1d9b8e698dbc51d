"""pytest plugin that runs tests on the mutants of one source file.

    python -m pytest -p tools.mutation.plugin -n 0 --mutate fmus/rotor_contact/contact/friction.py tests/rotor_contact

Tests first run on the unchanged source, which measures how long each takes and which mutants it reaches. Then the tests
that reach a mutant run on it, in a separate process, until one fails or `--mutant-seconds` have passed. Tests that are
fast and have killed other mutants run first.
"""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import hypothesis
import pytest
from _pytest.runner import runtestprotocol

from tools.instruments.loading import ChangedSources
from tools.mutation.mutants import Mutant, with_switches

MOST_TESTS = 250  # of a mutant; the number of the test that fails is an exit code


@dataclass
class _Test:
    """A test, how long it takes (s), which mutants it reaches, and how many it has killed."""

    item: pytest.Item
    seconds: float
    reached: set[int]
    kills: int = 0

    def cost(self) -> float:
        return self.seconds / (1 + self.kills)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--mutate", metavar="FILE", help="source file whose mutants are tested")
    parser.addoption("--mutant-seconds", type=float, default=30.0, help="largest CPU time (s) of the tests of a mutant")
    parser.addoption("--mutants", help="numbers of the mutants to try, with commas between; all by default")
    parser.addoption("--every", type=int, default=1, help="try every n-th mutant")


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    if early_config.known_args_namespace.mutate:  # before anything imports the file
        early_config.pluginmanager.register(_Campaign(Path(early_config.known_args_namespace.mutate).resolve()))


class _Campaign:
    def __init__(self, path: Path) -> None:
        self.path = path
        tree, self.mutants = with_switches(path.read_text(encoding="utf-8"))
        ChangedSources(lambda file: file.resolve() == path, lambda _: tree)

    def pytest_configure(self) -> None:
        phases = [hypothesis.Phase.explicit, hypothesis.Phase.generate]  # the first counterexample is enough
        hypothesis.settings.register_profile("mutation", deadline=None, derandomize=True, phases=phases)
        hypothesis.settings.load_profile("mutation")

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        options = session.config.option
        tests = self._run_unchanged(session)
        n = len(self.mutants)
        chosen = [int(k) for k in options.mutants.split(",")] if options.mutants else range(1, n + 1, options.every)
        outcomes: Counter[str] = Counter()
        for number in chosen:
            mutant = self.mutants[number - 1]
            reaching = [test for test in tests if number in test.reached]
            outcome = _outcome(number, sorted(reaching, key=_Test.cost), options.mutant_seconds)
            outcomes[outcome] += 1
            print(f"{number:4} line {mutant.line}: {_described(mutant)}  {outcome}", flush=True)
        print(f"{self.path.name}: {n} mutants, {sum(outcomes.values())} tried, {dict(outcomes)}", flush=True)
        return True

    def _run_unchanged(self, session: pytest.Session) -> list[_Test]:
        from tools.instruments.switch import reached

        tests: list[_Test] = []
        for item in session.items:
            for _ in range(2):
                reached()
                started = time.process_time()
                reports = runtestprotocol(item, nextitem=None, log=False)
                seconds = time.process_time() - started
                if seconds < 1.0:  # a longer test may have compiled kernels
                    break
            if all(report.passed for report in reports):
                tests.append(_Test(item, seconds, reached()))
            elif any(report.failed for report in reports):
                print(f"left out, because it fails: {item.nodeid}")
        print(f"{len(tests)} tests, {sum(test.seconds for test in tests):.1f} s", flush=True)
        return tests


def _described(mutant: Mutant) -> str:
    return f"{mutant.before}  ->  {mutant.after}"


def _outcome(number: int, tests: list[_Test], most: float) -> str:
    if not tests:
        return "not reached"
    child = os.fork()
    if child == 0:
        os._exit(_run(number, tests, most))
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "killed, it crashes or does not end"
    failed = os.WEXITSTATUS(status)
    if failed == 0:
        return "SURVIVED"
    tests[failed - 1].kills += 1
    return "killed"


def _run(number: int, tests: list[_Test], most: float) -> int:
    """Run tests on a mutant; return the place, from 1, of the first that fails, or 0."""
    from tools.instruments.switch import choose

    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    choose(number)
    started = time.process_time()
    for place, test in enumerate(tests[:MOST_TESTS], 1):
        if time.process_time() - started + test.seconds > most:
            break
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, 10.0 * test.seconds + 5.0)  # compiled kernels react to no other signal
        if any(report.failed for report in runtestprotocol(test.item, nextitem=None, log=False)):
            return place
    return 0
