"""The two flavours of an FMU of this project, with the same interface.

`python` is run by PythonFMU; `native` is compiled code that needs no Python.
"""

from typing import Literal, get_args

Flavour = Literal["python", "native"]
FLAVOURS: tuple[Flavour, ...] = get_args(Flavour)
