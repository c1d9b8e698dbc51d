"""A component whose C functions are a few lines of Python, for loops that call such functions."""

from ctypes import CFUNCTYPE, POINTER, c_double, c_int, c_size_t, c_uint, c_void_p, cast

import numpy as np

from amb_cosim.cosim.fmu.component import EntryPoints
from amb_cosim.cosim.fmu.exchange import Transfer

KINDS = {"Real": c_double, "Integer": c_int, "Boolean": c_int}
DO_STEP = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_int)
EXCHANGE = {
    kind: CFUNCTYPE(c_int, c_void_p, POINTER(c_uint), c_size_t, POINTER(number)) for kind, number in KINDS.items()
}


class Refused(Exception):
    pass


class CComponent:
    """A component with two Reals, an Integer and a Boolean in and out, whose step mixes what it was given.

    Value references of inputs are 7, 8, ..., of outputs 107, 108, ...; both loops call the same C functions. `answers`
    are statuses other than OK, by call and point in time; `trace` holds all calls with what they were given.
    """

    KINDS = ("Real", "Integer", "Real", "Boolean")

    def __init__(self, name, every=1, trace=None, answers=None, step_size=1e-3):
        self.name, self.every = name, every
        self.inputs, self.outputs = np.zeros(4), np.zeros(4)
        self.trace = [] if trace is None else trace
        self.memory = {reference: 0.0 for base in (7, 107) for reference in range(base, base + 4)}
        self.answers, self.now = answers or {}, None
        self.instance = 1000 + len(name)
        self.c_step = DO_STEP(self._do_step)
        self.c_set = {kind: EXCHANGE[kind](lambda *a, kind=kind: self._set(kind, *a)) for kind in KINDS}
        self.c_get = {kind: EXCHANGE[kind](lambda *a, kind=kind: self._get(kind, *a)) for kind in KINDS}

    def _set(self, kind, instance, references, size, values):
        settings = {references[k]: values[k] for k in range(size)}
        self.memory |= settings
        self.trace.append((self.name, "set", kind, instance, settings))
        return self.answers.get(("Set", self.now), 0)

    def _get(self, kind, instance, references, size, values):
        for k in range(size):
            values[k] = KINDS[kind](self.memory[references[k]]).value
        self.trace.append((self.name, "get", kind, instance, [references[k] for k in range(size)]))
        return self.answers.get(("Get", self.now), 0)

    def _do_step(self, instance, moment, step_size, no_way_back):
        self.now = moment
        a, i, b, flag = (self.memory[7 + k] for k in range(4))
        m = self.memory
        m[107], m[109] = 0.7 * m[107] + b / 3.0 + moment, m[109] - 0.1 * a + step_size * i
        m[108], m[110] = int(i) + 1, int(not flag)
        self.trace.append((self.name, "step", instance, moment, step_size, no_way_back))
        return self.answers.get(("DoStep", moment), 0)

    def _transfers(self, functions, base):
        for kind in KINDS:
            where = np.array([k for k, local in enumerate(self.KINDS) if local == kind])
            yield Transfer(
                cast(functions[kind], c_void_p).value, (where + base).astype(np.uint32), where, kind == "Real"
            )

    def entry_points(self):
        sends, fetches = (tuple(self._transfers(f, base)) for f, base in ((self.c_set, 7), (self.c_get, 107)))
        return EntryPoints(self.instance, cast(self.c_step, c_void_p).value, sends, fetches)

    def refusal(self, call, status):
        return Refused(f"{call} answered {status}")

    # The same calls from Python, for the plain loop:

    def _move(self, call, functions, base, values, store):
        for kind in KINDS:
            where = [k for k, local in enumerate(self.KINDS) if local == kind]
            buffer = (KINDS[kind] * len(where))(
                *(KINDS[kind](int(v) if kind != "Real" else v).value for v in values[where])
            )
            self._checked(
                call,
                functions[kind](self.instance, (c_uint * len(where))(*(w + base for w in where)), len(where), buffer),
            )
            if store:
                values[where] = list(buffer)

    def _checked(self, call, status):
        if status > 1:
            raise self.refusal(call, status)

    def write(self):
        self._move("Set", self.c_set, 7, self.inputs, store=False)

    def read(self):
        self._move("Get", self.c_get, 107, self.outputs, store=True)

    def step(self, moment, step_size):
        self._checked("DoStep", self.c_step(self.instance, moment, step_size, 1))

    def close(self):
        pass
