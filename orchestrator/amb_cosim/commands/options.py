"""Shared options; each has the name of the argument to which its value is passed."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import click

from amb_cosim.commands.cli_errors import Refused, refusing
from amb_cosim.cosim.choices import FLAVOURS, FMIS, LOOPS
from fmi_export.building.number_texts import plain_forms

_SETTING = re.compile(r"\s*([^\s=].*)=(.*\S.*)", re.DOTALL)

LARGEST_PACK_FILE = 2**16  # bytes of a pack.toml in which the default rotor is looked for

Option = Callable[[Callable[..., None]], Callable[..., None]]


def output(text: str, default: str | None = None, metavar: str | None = None) -> Option:
    """Return the option for the output file or folder, with the help `text`."""
    path = click.Path(path_type=Path)
    return click.option("-o", "--output", type=path, default=default, show_default=True, help=text, metavar=metavar)


def results_of(name: str | Path) -> Path:
    """Return the folder for the results of a scenario or file, such as results/pump_landing for `pump/landing.toml`."""
    path = Path(name)
    folder = "" if path.parent == Path() else path.parent.resolve().name
    return Path("results") / "_".join(filter(None, (folder, path.stem)))


def former_option(name: str, present: str) -> Option:
    """Return a hidden option that is refused with a hint to the option that replaces it."""

    def refuse(_: click.Context, __: click.Parameter, value: str | None) -> None:
        if value is not None:
            raise Refused(f"there is no option {name} any more; use '{present}'")

    return click.option(name, hidden=True, expose_value=False, callback=refuse)


def parse_settings(settings: Iterable[str]) -> dict[str, str]:
    """Return the values in `component.variable=value` texts by variable; the last text for a variable applies.

    The name of a variable, and the value of a String, may contain a `=`. A text with several `=` is first divided at
    the last one; `Assignments.set` then finds the actual end of the name.
    """
    parsed = {}
    for text in settings:
        match = _SETTING.fullmatch(text)
        if match is None:
            raise ValueError(f"{text!r} is not a setting; write component.variable=value")
        name, value = match.groups()
        parsed[name if "=" in name else name.strip()] = value if "=" in name else value.strip()
    return parsed


def _parsed(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
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


class WithUnit(click.ParamType):  # type: ignore[type-arg]  # generic in later versions alone
    """One or several quantities, separated by commas; each needs a unit, as a plain number could be in rpm or rad/s.

    `parts` is the function that separates the quantities.
    """

    name = "text"

    def __init__(self, *examples: str, parts: Callable[[str], list[str]] = lambda text: text.split(",")) -> None:
        self.examples = ", ".join(map(repr, examples))
        self.parts = parts

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the text; refuse a number without a unit, unless it is 0."""
        option = "" if param is None else param.opts[0]
        with refusing():
            for part in self.parts(value):
                if _is_number(part) and float(part):
                    forms = " or ".join(plain_forms(value))
                    hint = f"; commas separate quantities, so write a single number as {forms}" if forms else ""
                    raise ValueError(f"{option} {part.strip()} has no unit; write for example {self.examples}{hint}")
        return value


class RotorOption(click.Option):
    """The option for a rotor, whose help names the default rotor of the installed packs."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the names and the help of the option."""
        record = super().get_help_record(ctx)
        has_scenario = any(isinstance(parameter, click.Argument) for parameter in ctx.command.params)
        default = "the scenario's, or " * has_scenario + _default_rotor()
        return None if record is None else (record[0], f"{record[1]}; default: {default}.")


def _default_rotor() -> str:
    """Return the default rotor that the packs' files name, without importing the library that checks these files."""
    from amb_files.packs import packs

    for folder in packs().values():
        file = folder / "pack.toml"
        with suppress(OSError, ValueError, RecursionError, AttributeError):
            is_short = file.is_file() and file.stat().st_size <= LARGEST_PACK_FILE
            name = tomllib.loads(file.read_text(encoding="utf-8")).get("rotor") if is_short else None
            if name:
                return str(name)
    return "the default of a pack"


SPEED = WithUnit("12000 rpm", "200 Hz", "1257 rad/s")
FREQUENCY = WithUnit("100 Hz", "628 rad/s")
UNBALANCE = WithUnit("20 g.m", "65 g.mm")
CURRENT = WithUnit("4 A")
TIME = WithUnit("100 us", "0.1 ms")
STIFFNESS, DAMPING = WithUnit("1e6 N/m"), WithUnit("5000 N.s/m")
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
NO_PLOTS = click.option("--no-plots", is_flag=True, help="Draw no figures.")
UNITS: Option = click.option(
    "--units",
    default="",
    expose_value=False,
    callback=_choose_units,
    envvar="AMB_COSIM_UNITS",
    metavar="UNIT,...",
    help="Units of tables and figures: rpm, Hz, rad/s; mm, um, m; N, kN.",
)
ALL = click.option("--all", "show_all", is_flag=True, help="Print all values and the full warnings.")
UNTIL = click.option("--until", metavar="TIME", help="End time after the start of cycle 0, such as 300ms.")
ROTOR = click.option("--rotor", metavar="NAME|FILE", cls=RotorOption, help="Packaged rotor or rotor file")
FLAVOUR = click.option(
    "--flavour",
    type=click.Choice(FLAVOURS),
    default="native",
    show_default=True,
    help="Native FMUs, or Python FMUs built with PythonFMU.",
)
PLATFORMS = click.option(
    "--platform",
    "platforms",
    metavar="NAMES",
    callback=lambda _context, _option, text: text and [name.strip() for name in text.split(",")],
    help="Comma-separated platforms, or all; default: this platform.",
)
FMI = click.option(
    "--fmi",
    type=click.Choice([str(version) for version in FMIS]),
    default="2",
    show_default=True,
    callback=lambda _context, _option, text: int(text),
    help="FMI version: 2.0, or 3.0 (native FMUs only).",
)
RECEPTANCES = click.option(
    "--receptances",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Table of receptances for H; default: from the rotor model.",
)
SETTINGS = click.option(
    "--set",
    multiple=True,
    callback=_parsed,
    metavar="COMPONENT.VARIABLE=VALUE",
    help="Set a value; units are allowed.",
)
ISOLATED = click.option(
    "--isolated/--no-isolated",
    default=None,
    help="Run FMUs in a separate process; default for FMU files.",
)
LOOP = click.option(
    "--loop",
    type=click.Choice(LOOPS),
    default="compiled",
    show_default=True,
    help="Master loop: compiled, or plain Python for reference.",
)
