"""How the constants of an assembly say where everything of its parts lies in its arrays.

    constants:   head | parts | links | inputs watched | outputs gathered | ranges of outputs | constants of the parts
    parameters:  those of the parts in turn
    inputs:      the assembly's own
    outputs:     those of the parts in turn | fault code
    state:       states of the parts in turn | held: inputs of the parts in turn | shown: outputs of the controller
    work:        work arrays of the parts in turn | what outputs gather over the pieces of a step

Where a part has memory of its own, that begins at an even place: kernels use vectors of two numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of

Records = np.ndarray[tuple[int], np.dtype[np.record]]

REAL = np.dtype(np.float64)
N_PARTS = 3
ARRAYS = ("constants", "parameters", "held", "state", "work", "outputs")

# Places of the first number, and how many; those of `held` count from the first of all parts.
PART = record(
    *((f"{kind}_{array}", "f8") for array in ARRAYS for kind in ("first", "n")),
    ("first_link", "f8"),  # of the connections that start at the part
    ("n_links", "f8"),
    ("first_watched", "f8"),  # of its inputs that are watched
    ("n_watched", "f8"),
)
LINK = record(("source", "f8"), ("target", "f8"))  # from an input or an output of the assembly to an input in `held`
RUN = record(("source", "f8"), ("target", "f8"), ("size", "f8"))  # links side by side
WATCHED = record(("input", "f8"), ("lowest", "f8"), ("highest", "f8"), ("code", "f8"))  # code of leaving the range
HEAD = record(
    ("n_state", "f8"),
    ("n_work", "f8"),
    ("n_held", "f8"),
    ("n_outputs", "f8"),  # without the fault code
    ("first_held", "f8"),  # in the state
    ("first_gathered", "f8"),  # in the work array
    ("sample_time", "f8"),  # parameter of the controller
    ("slope", "f8"),  # input of the assembly that is the slope of the speed, or -1
    *((f"n_{table}", "f8") for table in ("given", "ramped", "connections", "watched", "flags", "sums")),
)
N_HEAD, N_PART, N_LINK, N_RUN, N_WATCHED = (size_of(r) for r in (HEAD, PART, LINK, RUN, WATCHED))


class Plan(NamedTuple):
    """Views into the constants.

    head, parts
        Records `HEAD`, in an array of one, and `PART`, in the order in which the parts step.
    given, ramped
        From the assembly's inputs: records `RUN`, and `LINK` for what follows the speed within a step.
    connections
        Records `LINK` from outputs, those of each part side by side.
    watched
        Records `WATCHED` of inputs whose values come from within the assembly, those of each part side by side.
    flags, sums
        Outputs that gather over a step: true where they were in a piece of it, and sums over the pieces.
    lowest, highest
        Range of each output.
    """

    head: Records
    parts: Records
    given: Records
    ramped: Records
    connections: Records
    watched: Records
    flags: Array
    sums: Array
    lowest: Array
    highest: Array


@views
def plan_of(constants: Array) -> Plan:
    """Return views into the constants of an assembly."""
    head = part(constants, 0, HEAD, 1)
    n_given, n_ramped, n_connections = int(head[0].n_given), int(head[0].n_ramped), int(head[0].n_connections)
    n_watched, n_flags, n_sums = int(head[0].n_watched), int(head[0].n_flags), int(head[0].n_sums)
    n_outputs = int(head[0].n_outputs)
    given = N_HEAD + N_PARTS * N_PART
    ramped = given + n_given * N_RUN
    connections = ramped + n_ramped * N_LINK
    watched = connections + n_connections * N_LINK
    flags = watched + n_watched * N_WATCHED
    sums = flags + n_flags
    lowest = sums + n_sums
    return Plan(
        head,
        part(constants, N_HEAD, PART, N_PARTS),
        part(constants, given, RUN, n_given),
        part(constants, ramped, LINK, n_ramped),
        part(constants, connections, LINK, n_connections),
        part(constants, watched, WATCHED, n_watched),
        part(constants, flags, REAL, n_flags),
        part(constants, sums, REAL, n_sums),
        part(constants, lowest, REAL, n_outputs),
        part(constants, lowest + n_outputs, REAL, n_outputs),
    )


class Shared(NamedTuple):
    """What the state and the work array hold besides those of the parts.

    held
        Inputs of the parts in turn.
    shown
        Outputs of the controller since its last sample.
    gathered
        What outputs gather over a step, shape (n_flags + n_sums,).
    """

    held: Array
    shown: Array
    gathered: Array


@views
def shared_of(state: Array, work: Array, plan: Plan) -> Shared:
    """Return views into the state and the work array."""
    head, n_shown = plan.head[0], int(plan.parts[0].n_outputs)
    return Shared(
        part(state, int(head.first_held), REAL, int(head.n_held)),
        part(state, int(head.first_held + head.n_held), REAL, n_shown),
        part(work, int(head.first_gathered), REAL, plan.flags.shape[0] + plan.sums.shape[0]),
    )


class Arrays(NamedTuple):
    """The arrays of an assembly or of a part; `held` are inputs of parts."""

    constants: Array
    parameters: Array
    held: Array
    state: Array
    work: Array
    outputs: Array


@views
def arrays_of(own: np.record, whole: Arrays) -> Arrays:
    """Return the arrays of a part as views into those of the assembly; `own` is its record `PART`."""
    return Arrays(
        part(whole.constants, int(own.first_constants), REAL, int(own.n_constants)),
        part(whole.parameters, int(own.first_parameters), REAL, int(own.n_parameters)),
        part(whole.held, int(own.first_held), REAL, int(own.n_held)),
        part(whole.state, int(own.first_state), REAL, int(own.n_state)),
        part(whole.work, int(own.first_work), REAL, int(own.n_work)),
        part(whole.outputs, int(own.first_outputs), REAL, int(own.n_outputs)),
    )


def n_state(constants: Array) -> int:
    """Return the size of the state of an assembly with these constants."""
    return int(plan_of(constants).head[0].n_state)


def n_work(constants: Array) -> int:
    """Return the size of the work array of an assembly with these constants."""
    return int(plan_of(constants).head[0].n_work)
