"""Options that several commands share, named as the arguments of the functions that they are passed to."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.cosim.basics.choices import FLAVOURS, FMIS, LOOPS

Option = Callable[[Callable[..., None]], Callable[..., None]]


def output(text: str, default: str | None = None, metavar: str | None = None) -> Option:
    """Return the option of what is written: a file or a folder, as the `text` says."""
    path = click.Path(path_type=Path)
    return click.option("-o", "--output", type=path, default=default, show_default=True, help=text, metavar=metavar)


def _parsed(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    from amb_cosim.scenario.plan import parse_settings

    with refusing():
        return parse_settings(texts)


def _choose_units(context: click.Context, _: click.Parameter, text: str) -> None:
    if text:
        from amb_cosim.presentation.units import units

        with refusing():
            context.with_resource(units(text))


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


class Speed(click.ParamType):  # type: ignore[type-arg]  # generic in later versions alone
    """One speed or several with commas, each with its unit: a number alone could be rpm as well as rad/s."""

    name = "speed"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the text, or refuse a number other than 0 without a unit."""
        option = "" if param is None else param.opts[0]
        with refusing():
            for part in value.split(","):
                if _is_number(part) and float(part):
                    raise ValueError(
                        f"{option} {part.strip()} has no unit; write for example '12000 rpm', '200 Hz', '1257 rad/s'"
                    )
        return value


SPEED = Speed()
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
NO_PLOTS = click.option("--no-plots", is_flag=True, help="Draw no figures.")
UNITS: Option = click.option(
    "--units",
    default="",
    expose_value=False,
    callback=_choose_units,
    envvar="AMB_COSIM_UNITS",
    metavar="UNIT,...",
    help="Units of figures: rpm, Hz or rad/s; mm, um or m; N or kN. By default rad/s, others by their size.",
)
EXPLAIN = click.option("--explain", is_flag=True, help="Print warnings whole, not cut to a line of the terminal.")
UNTIL = click.option("--until", metavar="TIME", help="End of a run, 0.3 (s) or 300ms, from the beginning of cycle 0.")
ROTOR = click.option(
    "--rotor", metavar="NAME|FILE", help="Rotor of a pack, or rotor file (TOML); the packs' default without."
)
FLAVOUR = click.option(
    "--flavour",
    type=click.Choice(FLAVOURS),
    default="native",
    show_default=True,
    help="Compiled FMUs that need no Python, or ones that PythonFMU runs, in a process that has Python.",
)
PLATFORMS = click.option(
    "--platform",
    "platforms",
    metavar="NAMES",
    callback=lambda _context, _option, text: text and [name.strip() for name in text.split(",")],
    help="linux64, win64, and for native FMUs darwin64, aarch64-linux, aarch64-darwin; some with commas, or all of "
    "these; wasm32, WebAssembly for browsers; this machine's by default.",
)
FMI = click.option(
    "--fmi",
    type=click.Choice([str(version) for version in FMIS]),
    default="2",
    show_default=True,
    callback=lambda _context, _option, text: int(text),
    help="Version of FMI: 2.0, or 3.0 for native FMUs, which has sensors and receptance as arrays.",
)
RECEPTANCES = click.option(
    "--receptances",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Table of receptances (TOML), as identify writes it, for the controller's H; the rotor model's H by default.",
)
SETTINGS = click.option(
    "--set",
    multiple=True,
    callback=_parsed,
    metavar="COMPONENT.VARIABLE=VALUE",
    help="Replace a value; units are understood.",
)
ISOLATED = click.option(
    "--isolated/--no-isolated",
    default=None,
    help="Whether FMUs run in a process of their own, so that a crash is a message; default for files.",
)
LOOP = click.option(
    "--loop",
    type=click.Choice(LOOPS),
    default="compiled",
    show_default=True,
    help="What calls the FMUs step by step: machine code, or Python, for reference.",
)
