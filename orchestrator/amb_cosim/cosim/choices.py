"""User choices. This module and `errors` import nothing, so that help and errors are displayed immediately."""

from __future__ import annotations

from typing import Literal, get_args

Flavour = Literal["native", "python"]  # compiled code that needs no Python, or run by PythonFMU
FLAVOURS: tuple[Flavour, ...] = get_args(Flavour)

Fmi = Literal[2, 3]  # version of FMI; FMUs of flavour python have 2.0
FMIS: tuple[Fmi, ...] = get_args(Fmi)

Loop = Literal["compiled", "plain"]
LOOPS: tuple[Loop, ...] = get_args(Loop)

Coupling = Literal["gauss_seidel", "jacobi", "iterative"]
COUPLINGS: tuple[Coupling, ...] = get_args(Coupling)

Role = Literal["disturbance", "relief"]  # of an event: the rotor is judged after a disturbance; relief takes it back
ROLES: tuple[Role, ...] = get_args(Role)

Settling = Literal["simulated", "solved", "automatic"]  # the last: solved where it can be
SETTLINGS: tuple[Settling, ...] = get_args(Settling)
