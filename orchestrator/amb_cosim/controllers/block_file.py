"""Controllers composed of blocks, in a TOML file.

    inputs = ["left.x", "right.x"]            # measured signals, as the matrices' columns
    outputs = ["left.i_x", "right.i_x"]       # demands
    sample_time = "100 us"
    method = "tustin"                      # as for `linear_controller`
    prewarp = true                         # the frequencies of blocks hold for the sampled law
    limits = ["-6.5 A", "5 A"]             # and delay = 1.5, slow_time = "0.1 s", allow_unstable = true

    [signals.tilting]                      # coordinates: sums of measured signals that channels may read
    "left.x" = 0.5
    "right.x" = -0.5

    [demands.tilting]                      # and sums of demands that they may drive
    "left.i_x" = 1
    "right.i_x" = -1

    [[channel]]                            # blocks in sequence; channels to the same demand add up
    from = "tilting"                       # a list for equal channels: from = ["left.x", "left.y"]
    to = "tilting"
    gain = -1.0                            # or over speed: [["0 rpm", -1.0], ["9000 rpm", -1.2]]
    blocks = [
      { type = "pid", kp = "2.3e4 A/m", kd = "36 A.s/m", roll_off = "3 kHz" },
      { type = "notch", frequency = "350 Hz", damping = 0.1 },   # or over speed, as a gain
    ]

To couple axes, add a channel from one axis to the other. The module `blocks` describes the blocks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from amb_cosim.controllers.blocks import Block, Warp, schedule
from amb_cosim.controllers.discretisation import check_sample_time, sampled
from amb_cosim.controllers.laws import Law, in_series, law_of, side_by_side
from amb_cosim.cosim.system.tables import Table, Value
from amb_cosim.cosim.system.values import quantity
from amb_files.checks import errors_in
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, validate
from array_types import Array

Names = Annotated[tuple[str, ...], Field(min_length=1, max_length=64)]
Gains = Annotated[tuple[tuple[Value, float], ...], Field(min_length=1, max_length=1000)]


class Channel(Table):
    """Blocks in series from a signal to a demand; each of several signals has its own copy and its own demand."""

    from_: Annotated[str | Names, Field(alias="from")]
    to: str | Names
    gain: float | Gains = 1.0
    blocks: Annotated[tuple[Block, ...], Field(max_length=100)] = ()


class ControllerTable(Table):
    """The content of a controller file."""

    description: str = ""
    inputs: Names
    outputs: Names
    sample_time: Value
    method: str = "tustin"
    prewarp: bool = False
    delay: float = 0.0
    slow_time: Value = 0.1
    limits: tuple[Value, Value] | None = None
    allow_unstable: bool = False
    signals: dict[str, dict[str, float]] = Field(default={})
    demands: dict[str, dict[str, float]] = Field(default={})
    channel: Annotated[tuple[Channel, ...], Field(min_length=1, max_length=1000)]


def read_blocks(path: Path, continuous: bool = False) -> dict[str, Any]:
    """Return the content of a file as arguments of `linear_controller`.

    Parameters
    ----------
    continuous
        Whether the law stays continuous, without prewarping.

    Raises
    ------
    ValueError
        If the file cannot be read or is invalid; the message has one line for each error of form.
    """
    table = validate(read_toml(path, "controller"), ControllerTable, "controller")
    time = check_sample_time(quantity(table.sample_time, "s", "sample_time"))
    if table.prewarp and table.method != "tustin":
        raise ValueError(f"prewarp is not allowed with {table.method}; only tustin supports it")

    def warp(omega: float) -> float:
        if not table.prewarp or continuous:
            return omega
        if omega >= math.pi / time:
            raise ValueError(
                f"a frequency of {omega / (2.0 * math.pi):g} Hz is not allowed with prewarp; it must be below half "
                f"the sampling frequency, {0.5 / time:g} Hz"
            )
        return 2.0 / time * math.tan(omega * time / 2.0)

    laws = _laws(table, warp)
    if not continuous:
        laws = {speed: sampled(law, time, table.method) for speed, law in laws.items()}
    limits = None if table.limits is None else [quantity(raw, "A", "limits") for raw in table.limits]
    return {
        "K": laws if len(laws) > 1 else next(iter(laws.values())),
        "inputs": list(table.inputs),
        "outputs": list(table.outputs),
        "sample_time": time,
        "delay": table.delay,
        "slow_time": quantity(table.slow_time, "s", "slow_time"),
        "limits": limits,
        "allow_unstable": table.allow_unstable,
    }


def _laws(table: ControllerTable, warp: Warp) -> dict[float, Law]:
    """Return the continuous law for each speed at which a gain or a frequency is set."""
    reads, feeds, owners, gains = [], [], [], []
    speeds: set[float] = set()
    for number, channel in enumerate(table.channel, 1):
        where = f"channel {number}"
        ends = [[end] if isinstance(end, str) else list(end) for end in (channel.from_, channel.to)]
        if len(ends[0]) != len(ends[1]):
            raise ValueError(
                f"{where}: 'from' has {len(ends[0])} names and 'to' has {len(ends[1])}; the numbers must be equal"
            )
        gains.append(_gains(channel, where))
        speeds |= {speed for speed, _ in gains[-1]}
        for k, block in enumerate(channel.blocks, 1):
            with errors_in(f"{where}: block {k} ({block.type})"):
                speeds |= {*block.speeds()}
        for source, target in zip(*ends, strict=True):
            owners.append(number - 1)
            reads.append(_weights(source, table.inputs, table.signals, f"{where}: from", "signals"))
            feeds.append(_weights(target, table.outputs, table.demands, f"{where}: to", "demands"))
    B, laws_by_speed = np.array(reads), {}
    for speed in sorted(speeds):
        laws = [_in_series(channel, speed, warp, f"channel {k}") for k, channel in enumerate(table.channel, 1)]
        parallel = side_by_side([laws[k] for k in owners])
        factors = [np.interp(speed, *np.array(gains[k]).T) for k in owners]
        C = np.array(feeds).T * factors
        laws_by_speed[speed] = Law(parallel.A, parallel.B @ B, C @ parallel.C, C @ parallel.D @ B, parallel.sample_time)
    return laws_by_speed


def _in_series(channel: Channel, speed: float, warp: Warp, where: str) -> Law:
    law = law_of(1.0)
    for k, block in enumerate(channel.blocks, 1):
        with errors_in(f"{where}: block {k} ({block.type})"):
            law = in_series(law, block.at(speed).law(warp))
    return law


def _gains(channel: Channel, where: str) -> list[tuple[float, float]]:
    """Return gains by ascending speed (rad/s); a single gain gets the speed 0."""
    if isinstance(channel.gain, int | float):
        gains = [(0.0, float(channel.gain))]
    else:
        with errors_in(where):
            gains = schedule(channel.gain, "gain", lambda raw, _: float(raw))
    if not np.isfinite(gains).all():
        raise ValueError(f"{where}: gain must be finite")
    return gains


def _weights(name: str, ports: Sequence[str], sums: Mapping[str, Mapping[str, float]], where: str, kind: str) -> Array:
    """Return the weight of each port in the port or sum of ports that `name` denotes."""
    if name not in sums and name not in ports:
        raise ValueError(f"{where} = {name!r} is not allowed; {suggest(name, [*ports, *sums])}")
    weights = np.zeros(len(ports))
    for port, weight in sums.get(name, {name: 1.0}).items():
        if port not in ports:
            raise ValueError(f"{kind}.{name}: {port!r} is not allowed; {suggest(port, ports)}")
        if not np.isfinite(weight):
            raise ValueError(f"{kind}.{name}: {port} = {weight} is not allowed; it must be finite")
        weights[ports.index(port)] = weight
    return weights
