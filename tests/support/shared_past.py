"""Points of a sweep that share what lies before their step: they end as points do that run it each."""

from __future__ import annotations

from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task


def assert_shared_past_changes_nothing(scenario: Scenario, step: str) -> None:
    """Fail if two sizes of a step at `step` end otherwise, to the last bit, where they share their past."""
    message = []
    for labels in ((), ("step",)):
        runner = Runner(Task(scenario, labels=labels))
        results = [runner.run(n, {step: size}) for n, size in enumerate(("90 g.mm", "110 g.mm"))]
        runner.close()
        shared = [result.metrics.pop("shared", 0.0) for result in results]
        message.append([(r.outcome, r.reason, str(r.metrics)) for r in results])
    assert message[0] == message[1]
    assert message[0][0] != message[0][1], "the points differ"
    assert shared[0] == 0.0 < shared[1]
