"""The master algorithm on components that are a few lines of arithmetic."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from amb_cosim.cosim.errors import FmuError, StartFailed, StepFailed
from amb_cosim.cosim.grid.schedules import PiecewiseConstant, PiecewiseLinear
from amb_cosim.cosim.grid.time_grid import TimeGrid
from amb_cosim.cosim.master.master import Master, find_loop
from amb_cosim.cosim.system.signal_map import SignalMap
from tests.support.messages import assert_names, raises_naming


class Block:
    """A component y = output(x, u) with x' advanced by `advance`; it logs its calls."""

    def __init__(
        self,
        name: str,
        n_inputs: int = 1,
        advance: Callable[[float, np.ndarray, float, float], float] = lambda x, u, t, h: x,
        output: Callable[[float, np.ndarray], float] = lambda x, u: x,
        x: float = 0.0,
        every: int = 1,
        trace: list | None = None,
    ) -> None:
        self.name, self.every, self.x = name, every, x
        self.inputs, self.outputs = np.zeros(n_inputs), np.zeros(1)
        self._u = np.zeros(n_inputs)
        self._advance, self._output = advance, output
        self.trace = [] if trace is None else trace
        self.closed = 0

    def enter(self, start_time: float) -> None:
        self.trace.append((self.name, "enter", start_time))

    def leave(self) -> None:
        self.trace.append((self.name, "leave"))

    def write(self) -> None:
        self._u = self.inputs.copy()

    def read(self) -> None:
        self.outputs[0] = self._output(self.x, self._u)

    def step(self, time: float, step_size: float) -> None:
        self.trace.append((self.name, "step", time, step_size))
        self.x = self._advance(self.x, self._u, time, step_size)

    def close(self) -> None:
        self.closed += 1


def closed_chain(*names: str) -> SignalMap:
    """Each component is fed by the one before it, the first by the last; every output comes a step later."""
    n = len(names)
    return SignalMap(names, 0, tuple(np.array([(i - 1) % n]) for i in range(n)), ((),) * n)


def relay(name: str, x: float = 0.0, **options) -> Block:
    """Its output is the input at the beginning of its last step, plus one."""
    return Block(name, advance=lambda x, u, t, h: u[0] + 1.0, x=x, **options)


def run(master: Master, steps: int, schedules=()) -> dict[str, list[float]]:
    """Values at each point, by the name of the signal."""
    rows: list[list[float]] = []
    master.initialise()
    master.run(0, steps, schedules, [lambda n, values: rows.append(values.tolist())])
    return dict(zip(master.wiring.names, map(list, zip(*rows, strict=True)), strict=True))


@pytest.mark.parametrize(
    ("coupling", "values"),
    [
        ("gauss_seidel", {"a": [0, 1, 4], "b": [0, 2, 5], "c": [0, 3, 6]}),
        ("jacobi", {"a": [0, 1, 2], "b": [0, 1, 2], "c": [0, 1, 2]}),
    ],
)
def test_only_gauss_seidel_passes_new_outputs_on_within_a_step(coupling, values):
    assert run(Master([relay(name) for name in "abc"], closed_chain("a", "b", "c"), 0.1, coupling), 2) == values


def test_gauss_seidel_steps_components_in_their_order():
    wiring = SignalMap(("b", "a"), 0, (np.array([1]), np.array([0])), ((), ()))
    assert run(Master([relay("b"), relay("a", x=10.0)], wiring, 0.1), 1) == {"b": [0, 11], "a": [10, 12]}


@pytest.mark.slow
def test_time_is_exact_after_a_million_steps():
    last = []
    clock = Block("clock", n_inputs=0, advance=lambda x, u, t, h: last.append(t) or t)
    master = Master([clock], SignalMap(("clock",), 0, (np.array([], dtype=int),), ((),)), 0.1, start_time=3.0)
    clock.trace = _Nothing()
    master.run(0, 1_000_001)
    assert last[-1] == 3.0 + 1_000_000 * 0.1
    assert sum([0.1] * 1_000_000, 3.0) != last[-1]


class _Nothing(list):
    def append(self, _: object) -> None:
        pass


def test_a_slow_component_steps_at_the_beginning_of_its_interval():
    trace: list = []
    fast, slow = Block("fast", trace=trace), Block("slow", every=3, trace=trace)
    run(Master([slow, fast], closed_chain("slow", "fast"), 0.5), 4)
    steps = [event for event in trace if event[1] == "step"]
    assert steps == [
        ("slow", "step", 0.0, 1.5),
        ("fast", "step", 0.0, 0.5),
        ("fast", "step", 0.5, 0.5),
        ("fast", "step", 1.0, 0.5),
        ("slow", "step", 1.5, 1.5),
        ("fast", "step", 1.5, 0.5),
    ]


def test_a_slow_component_holds_its_output_under_gauss_seidel():
    counter = Block("counter", advance=lambda x, u, t, h: x + 1.0)
    slow = Block("slow", advance=lambda x, u, t, h: u[0], every=2)
    record = run(Master([counter, slow], closed_chain("counter", "slow"), 0.1), 4)
    assert record["slow"] == [0, 1, 1, 3, 3]


@pytest.mark.parametrize(("every", "published"), [(2, [0, 0, 10, 10, 12]), (3, [0, 0, 0, 10, 10, 10, 13])])
def test_a_slow_component_publishes_after_its_interval_under_jacobi(every, published):
    counter = Block("counter", advance=lambda x, u, t, h: x + 1.0)
    slow = Block("slow", advance=lambda x, u, t, h: u[0] + 10.0, every=every)
    record = run(Master([counter, slow], closed_chain("counter", "slow"), 0.1, "jacobi"), 2 * every)
    assert record["slow"] == published


def test_a_slow_component_steps_at_multiples_of_its_interval_only():
    slow = Block("slow", every=4)
    master = Master([slow], closed_chain("slow"), 0.5)
    with raises_naming(ValueError, "slow", "4 communication points", "-3"):
        master.run(-3, 0)
    assert slow.trace == []
    master.run(-8, 0)
    assert slow.trace == [("slow", "step", -4.0, 2.0), ("slow", "step", -2.0, 2.0)]


def test_outputs_are_propagated_during_initialisation_against_the_order():
    """A chain c <- b <- a whose first link comes last needs a sweep for each link."""
    source = Block("a", n_inputs=0, x=1.0)
    links = [Block(name, output=lambda x, u: 2.0 * u[0]) for name in ("c", "b")]
    wiring = SignalMap(("c", "b", "a"), 0, (np.array([1]), np.array([2]), np.array([], dtype=int)), ((1,), (2,), ()))
    master = Master([*links, source], wiring, 0.1)
    master.initialise()
    assert master.values.tolist() == [4.0, 2.0, 1.0]


def test_exogenous_inputs_reach_the_components_during_initialisation():
    wiring = SignalMap(("u", "y"), 1, (np.array([0]),), ((), (0,)))
    master = Master([Block("gain", output=lambda x, u: 3.0 * u[0])], wiring, 0.1)
    master.exogenous[:] = 5.0
    master.initialise(-7)
    assert master.values.tolist() == [5.0, 15.0]
    assert master.components[0].trace == [("gain", "enter", -7 * 0.1), ("gain", "leave")]


def test_outputs_that_do_not_settle_are_reported_with_their_loop():
    blocks = [Block(name, output=lambda x, u: 1.0 - 0.5 * u[0]) for name in ("a.y", "b.y")]
    wiring = SignalMap(("a.y", "b.y"), 0, (np.array([1]), np.array([0])), ((1,), (0,)))
    with pytest.raises(StartFailed, match=r"algebraic loop is (a\.y -> b\.y -> a\.y|b\.y -> a\.y -> b\.y)"):
        Master(blocks, wiring, 0.1).initialise()
    restless = Block("a.y", output=lambda x, u: u[0] + 1.0)
    with raises_naming(StartFailed, "settle", "initialisation", "no loop"):
        Master([restless], closed_chain("a.y"), 0.1).initialise()


def test_a_declared_algebraic_loop_that_converges_is_no_error():
    blocks = [Block(name, output=lambda x, u: min(u[0], 0.0)) for name in ("a.y", "b.y")]
    wiring = SignalMap(("a.y", "b.y"), 0, (np.array([1]), np.array([0])), ((1,), (0,)))
    Master(blocks, wiring, 0.1).initialise()


def test_an_algebraic_loop_is_identified_among_other_paths():
    loop = find_loop([(), (0,), (1, 4), (2,), (3,), (4,)])
    assert loop[0] == loop[-1]
    assert set(loop) == {2, 3, 4}
    assert all(b == {2: 3, 3: 4, 4: 2}[a] for a, b in pairwise(loop)), "a signal reaches the next"
    assert find_loop([(), (0,), (0, 1)]) == []


def test_events_hold_from_their_point_on():
    wiring = SignalMap(("u", "y"), 1, (np.array([0]),), ((), ()))
    follower = Block("follower", advance=lambda x, u, t, h: u[0])
    record = run(Master([follower], wiring, 0.1), 4, [PiecewiseConstant([(1, 0, 7.0), (3, 0, 2.0)])])
    assert record == {"u": [0, 7, 7, 2, 2], "y": [0, 0, 7, 7, 2]}


PROFILE = PiecewiseLinear([(0, 10.0), (4, 10.0), (8, 30.0), (10, 25.0)], TimeGrid(0.5), value=1, slope=0)


def at(n: int) -> tuple[float, float]:
    """Value and slope that the profile writes at point n."""
    exogenous = np.full(2, np.nan)
    PROFILE(n, exogenous)
    return exogenous[1], exogenous[0]


def test_a_profile_is_linear_between_its_points_and_constant_outside():
    """A value carried on by its slope, as a component does within a step, meets the next value without a jump."""
    assert [at(n)[0] for n in (-7, 0, 3, 4, 5, 6, 8, 9, 10, 50)] == [10, 10, 10, 10, 15, 20, 30, 27.5, 25, 25]
    assert [at(n)[1] for n in (-7, 3, 4, 7, 8, 9, 10)] == [0, 0, 10, 10, -5, -5, 0]
    for n in range(-2, 12):
        value, slope = at(n)
        assert value + slope * 0.5 == pytest.approx(at(n + 1)[0], rel=1e-15)
    exogenous = np.zeros(2)
    PiecewiseLinear([(0, 0.0), (10_000_000, 1.0)], TimeGrid(1e-3), 0, 1)(9_999_999, exogenous)
    assert exogenous[0] == 9_999_999 / 10_000_000, "a long run has no accumulated error"


def test_schedules_write_before_observers_see_a_point():
    wiring = SignalMap(("slope", "u", "y"), 2, (np.array([1]),), ((), (), ()))
    follower = Block("follower", advance=lambda x, u, t, h: u[0])
    events = PiecewiseConstant([(1, 0, 7.0)])
    profile = PiecewiseLinear([(0, 1.0), (2, 5.0)], TimeGrid(0.1), 1, 0)
    record = run(Master([follower], wiring, 0.1), 2, [profile, events])
    assert record["u"] == [1, 3, 5]
    assert record["y"] == [0, 1, 3]
    assert record["slope"][1] == 7.0, "of two schedules the later one counts"


def failing(name: str, at: float) -> Block:
    def advance(x: float, u: np.ndarray, t: float, h: float) -> float:
        if t >= at:
            raise RuntimeError("fmi2DoStep answered Discard: the rotor left the bearing")
        return x + 1.0

    return Block(name, advance=advance)


def test_a_failing_step_keeps_the_record_and_frees_all():
    record: list[float] = []
    good, bad = Block("good"), failing("bad", at=0.3)
    with pytest.raises(StepFailed) as caught, Master([good, bad], closed_chain("good", "bad"), 0.1) as master:
        master.run(0, 100, (), [lambda n, values: record.append(values[1])])
    assert record == [0, 1, 2, 3]
    assert (good.closed, bad.closed) == (1, 1)
    assert caught.value.component == "bad"
    assert caught.value.time == pytest.approx(0.3)
    assert_names(caught, "bad", "0.3 s", "fmi2DoStep", "Discard", "the rotor left the bearing")


def test_error_names_the_source_of_a_refused_nan():
    def refuse(x: float, u: np.ndarray, t: float, h: float) -> float:
        if np.isnan(u).any():
            raise RuntimeError("u = nan is not allowed")
        return x + 1.0

    source = Block("source", advance=lambda x, u, t, h: np.nan if t >= 0.3 else x + 1.0)
    parts, wiring = [source, Block("receiver", advance=refuse)], closed_chain("source", "receiver")
    with pytest.raises(StepFailed) as caught, Master(parts, wiring, 0.1) as master:
        master.run(0, 100)
    assert (caught.value.component, caught.value.time) == ("receiver", pytest.approx(0.3))
    assert_names(caught, "u = nan", "from source is nan")


def test_an_interrupt_by_an_observer_frees_all():
    block = Block("block")

    def observe(n: int, _: np.ndarray) -> None:
        if n == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Master([block], closed_chain("block"), 0.1) as master:
        master.run(0, 100, (), [observe])
    assert [event[2] for event in block.trace] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert block.closed == 1


def test_outputs_that_appear_as_initialisation_ends_pass_along_a_chain():
    source, *pipes = (Block(name, int(name != "a"), output=lambda x, u: x + u.sum()) for name in "abc")
    source.leave = lambda: setattr(source, "x", 7.0)
    wiring = SignalMap(("a", "b", "c"), 0, (np.array([], int), np.array([0]), np.array([1])), ((), (0,), (1,)))
    master = Master([source, *pipes], wiring, 0.1)
    master.initialise()
    assert master.values.tolist() == [7.0, 7.0, 7.0]


def test_the_last_step_of_a_component_may_be_shorter():
    trace: list = []
    block = Block("a", trace=trace)
    master = Master([block], closed_chain("a"), 0.5, end=(3, 1.25), last_steps={0: (2, 0.25)})
    master.run(0, 3)
    assert [event[2:] for event in trace] == [(0.0, 0.5), (0.5, 0.5), (1.0, 0.25)]
    assert master.time(3) == 1.25


def test_a_run_that_stops_before_a_point_continues_there():
    memory = np.zeros(4)
    whole, parts = (Master([relay("a"), relay("b")], closed_chain("a", "b"), 0.1, values=part)
                    for part in (memory[:2], memory[2:]))  # fmt: skip
    whole.run(0, 5)
    parts.run(0, 5, stop=2)
    assert memory[2:].tolist() == [3.0, 4.0]
    parts.run(2, 5)
    assert memory[2:].tolist() == memory[:2].tolist() == [9.0, 10.0]


@pytest.mark.parametrize(
    ("coupling", "every", "end", "values"),
    [
        ("gauss_seidel", 1, 0.1, [5.0, 6.0]),
        ("jacobi", 1, 0.1, [5.0, 1.0]),  # the second has stepped with the output before
        ("iterative", 1, 0.1, None),
        ("gauss_seidel", 1, 0.05, None),
        ("gauss_seidel", 2, 0.1, None),
    ],
)
@pytest.mark.parametrize("ends", [False, True])
def test_a_step_that_ends_a_run_is_completed_at_points_alone(coupling, every, end, values, ends):
    """The second component takes the step, too, or also ends the run there."""
    first, second = relay("first", x=5.0, every=every), relay("second")
    master = Master([first, second], closed_chain("first", "second"), 0.1, coupling)
    if ends:
        step = second.step

        def step_and_end(time: float, step_size: float) -> None:
            step(time, step_size)
            raise FmuError("fmi2DoStep", "Discard", [], 0.1)

        second.step = step_and_end
    assert master.complete(0, 0, end) == (values is not None)
    assert master.values.tolist() == (values or [0.0, 0.0])


@pytest.mark.parametrize("end", [None, 0.05])
def test_a_step_in_which_another_component_fails_or_ends_earlier_is_left_out(end):
    second = relay("second")
    second.step = lambda *_: (_ for _ in ()).throw(FmuError("fmi2DoStep", "Discard", [], end))
    master = Master([relay("first", x=5.0), second], closed_chain("first", "second"), 0.1)
    assert not master.complete(0, 0, 0.1)


def test_a_component_alone_completes_its_step_at_any_time():
    master = Master([relay("a", x=5.0)], closed_chain("a"), 0.1)
    assert master.complete(0, 0, 0.03)
    assert master.values.tolist() == [5.0]


@pytest.mark.parametrize(
    ("names", "step", "facts"),
    [
        *((["a"], step, ("communication step",)) for step in (0.0, -1e-3, float("nan"), float("inf"))),
        (["a", "b"], 0.1, ("1 signals", "2")),
    ],
)
def test_steps_that_are_not_positive_and_wiring_of_too_few_signals_are_refused(names, step, facts):
    with raises_naming(ValueError, *facts):
        Master([Block(name) for name in names], closed_chain("a"), step)
