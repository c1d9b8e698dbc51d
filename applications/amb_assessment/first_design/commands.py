"""The command that writes a first design of a machine."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from amb_cosim.commands.cli import main
from amb_cosim.commands.cli_errors import Failed, refusing
from amb_cosim.commands.options import FLAVOUR, SPEED, WithUnit
from amb_cosim.commands.printing import warn_of_sizes
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.system.values import RPM

if TYPE_CHECKING:
    from amb_assessment.first_design.design import Design
    from amb_assessment.first_design.sizing import Drive, MagnetData
    from amb_assessment.first_design.thrust import Thrust

APART = 1.8  # factor above which constants of a magnet are questioned


def _positions(text: str) -> list[str]:
    """Return the positions in a text such as '0.2m 1.0m' or '0.2 m, 1.0 m'."""
    return re.sub(r"\s+(?=[A-Za-z])", "", text.replace(",", " ")).split()


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--rotor", metavar="NAME|FILE", help="Rotor file of the drawing (TOML), or a rotor of a pack.")
@click.option("--mass", type=WithUnit("60 kg"), help="Mass of the rotor, such as '60 kg'.")
@click.option("--length", type=WithUnit("1.2 m"), help="Length of the rotor, such as '1.2 m'.")
@click.option("--speed", type=SPEED, help="Highest operating speed, such as '12000 rpm'.")
@click.option(
    "--bearings",
    type=WithUnit("0.2 m 1.0 m", parts=_positions),
    metavar="'Z Z'",
    help="Positions of the two bearings, such as '0.2 m 1.0 m'.",
)
@click.option("--k-i", type=WithUnit("210 N/A"), help="K_i of an axis from a data sheet, such as '210 N/A'.")
@click.option("--k-s", type=WithUnit("1.5e6 N/m"), help="K_s at the centre, such as '1.5e6 N/m'; with --k-i.")
@click.option(
    "--gap",
    type=WithUnit("0.4 mm"),
    help="Air gap of the magnets; default: twice the retainers' clearance, or about 1/250 of the shaft's diameter.",
)
@click.option("--tilt", type=WithUnit("90 deg"), help="Angle of the shaft above the horizontal; default: 0 deg.")
@click.option(
    "--thrust-disc", is_flag=True, help="Add an axial bearing, and faces that stop the rotor along its shaft."
)
@click.option("--bias", type=WithUnit("2 A"), help="Bias current for --k-i and --k-s; it implies --gap.")
@click.option(
    "--sample-time",
    type=WithUnit("50 us"),
    help="Sample time of the controller; default: 50 us, or less if that is too long.",
)
@click.option(
    "--bandwidth",
    type=WithUnit("2 kHz"),
    help="Bandwidth of the amplifiers for small signals; default: 1.4 kHz, or twice the speed.",
)
@click.option(
    "--drive",
    type=click.Choice(["differential", "one-sided"]),
    help="Coils that carry the load: both (default), or only the upper ones.",
)
@FLAVOUR
def new(
    folder: Path,
    rotor: str | None,
    mass: str | None,
    length: str | None,
    speed: str | None,
    bearings: str | None,
    k_i: str | None,
    k_s: str | None,
    gap: str | None,
    tilt: str | None,
    thrust_disc: bool,
    bias: str | None,
    sample_time: str | None,
    bandwidth: str | None,
    drive: Drive | None,
    flavour: Flavour,
) -> None:
    """Write a first design of a machine into a new FOLDER.

    The folder contains the rotor, its magnets, a controller that levitates the rotor, and scenarios.

    The rotor is read from a file, or it is a plain shaft with a given mass and length. The command prompts for missing
    values.
    """
    from amb_assessment.first_design.files import NotLevitated, new_machine
    from amb_assessment.first_design.levitation import TRIP
    from amb_assessment.first_design.rotor_text import require_speed
    from amb_cosim.cosim.system.values import quantity
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.presentation.progress import STARTING, bars

    with refusing():
        magnet = _magnet(k_i, k_s, gap, bias, drive)
        written = speed or _asked("speed", SPEED)
        Omega = quantity(written, "rad/s", "speed")
        require_speed(Omega, written)
        text = _rotor_text(folder.name, rotor, mass, length, Omega)
        places = None if bearings is None else [quantity(z, "m", "bearings") for z in _positions(bearings)]
        if places is not None and len(places) != 2:
            raise ValueError(f"bearings = {bearings!r} is not allowed; it must be two positions, such as '0.2 m 1.0 m'")
        positions = None if places is None else (places[0], places[1])
        with bars(plain_console(stderr=True)) as progress:
            task = progress.add_task(STARTING, total=None)

            def report(sample_time: float, tried: int) -> None:
                progress.update(task, description=f"sample time {1e6 * sample_time:g} µs, gains tried: {tried}")

            air, angle = None if gap is None else quantity(gap, "m", "gap"), quantity(tilt or 0.0, "rad", "tilt")
            try:
                machine = new_machine(
                    *(folder, text, Omega, positions, magnet, flavour, report),
                    gap=air,
                    tilt=angle,
                    thrust_disc=thrust_disc,
                    sample_time=None if sample_time is None else quantity(sample_time, "s", "sample time"),
                    bandwidth=None if bandwidth is None else quantity(bandwidth, "Hz", "bandwidth"),
                )
            except NotLevitated as error:
                machine = error.machine
    _echo_design(folder.name, machine.design)
    for bearing, point in machine.points.items():
        upper, lower = point.coils
        click.echo(
            f"bearing {bearing}: each axis carries {machine.sizes.loads[bearing]:.4g} N of the weight with "
            f"{upper:.4g} A in the upper coils and {lower:.4g} A in the lower coils; "
            f"K_s {point.k_s:.4g} N/m, K_i {point.k_i:.4g} N/A"
            + ("" if magnet is None else f" (data sheet: {magnet.k_s:.4g} N/m, {magnet.k_i:.4g} N/A)")
        )
        if machine.sizes.retainers and bearing not in {site.bearing for site in machine.sizes.retainers}:
            click.echo(
                f"bearing {bearing} has no retainer; if it is passive, list it under [[seals]] of the rotor file"
            )
    sizes = machine.sizes
    if machine.axis is not None:
        _echo_axis(machine.axis, is_drawn="thrust_disc" not in machine.assumed)
    click.echo(
        f"magnets: {sizes.turns} turns on each pole, {1e4 * sizes.pole_area:.3g} cm2, gap {1e3 * sizes.gap:.3g} mm, "
        f"bias {sizes.bias_current:.3g} A, at most {sizes.current_limit:.3g} A"
        + _comparison(magnet, machine.typical, machine.lying)
    )
    if magnet is not None:
        click.echo(_assumed(magnet))
    if tilt is None:
        click.echo("the shaft is assumed to be horizontal; set --tilt '90 deg' for an upright shaft")
    if gap is None and magnet is None:
        basis = "twice the least clearance" if "bearings" not in machine.assumed else "about 1/250 of the diameter"
        click.echo(f"the gap is assumed, {basis}; set it with --gap")
    click.echo(
        f"the largest current of {sizes.current_limit:.3g} A and the trip speed of {TRIP * sizes.speed * RPM:.5g} rpm "
        "are assumed; enter yours as current_limit in levitation.toml and trip in machine.toml"
    )
    if bandwidth is None:
        click.echo(
            f"amplifiers of {1e-3 * sizes.bandwidth:.3g} kHz are assumed, 1.4 kHz or twice the frequency of the speed; "
            "set --bandwidth"
        )
    click.echo(_lag(machine.design, sizes.bandwidth))
    if not sizes.retainers:
        click.echo("the rotor has no retainers and cannot land; add them to rotor.toml as [[sites]] with a bearing")
    if "bearings" in machine.assumed:
        click.echo("retainers and sensors are placed next to the bearings; move them in rotor.toml if necessary")
    if "thrust_disc" in machine.assumed:
        click.echo("thrust disc and faces are placed at the lower end; move them in rotor.toml if necessary")
    if "damping" in machine.assumed:
        click.echo("damping of the bending modes is assumed: 0.3, 0.5, then 1 %; enter measured values in rotor.toml")
    reduction = sizes.rotor.reduction
    if reduction.method == "free_modes" and not reduction.speed:
        click.echo(
            "the [reduction] of the rotor file states no speed, so the simulated rotor may whirl too fast; add speed = "
            f"'{TRIP * sizes.speed * RPM:.5g} rpm' to [reduction] in rotor.toml, and check the error with 'rotor show'"
        )
    if sizes.retainers:
        click.echo(
            "no windage is assumed: without spin.drag in levitation.toml, only the retainers slow down an undriven "
            "rotor"
        )
    if machine.design.refusal:
        raise Failed(f"{machine.design.refusal}; {folder} has the design that comes closest")
    first = folder / ("landing.toml" if sizes.retainers else "levitation.toml")
    click.echo(f"wrote {folder}; next: amb-cosim run {first}")


def _echo_axis(axis: Thrust, *, is_drawn: bool) -> None:
    """Print the operating point of the axial magnet and, for a disc of the rotor file, what is assumed about it."""
    (upper, lower), point, magnet = axis.coils, axis.point, axis.magnet
    click.echo(
        f"thrust disc {axis.name}: its magnet carries {abs(axis.load):.4g} N of the weight with {upper:.4g} A in the "
        f"upper coil and {lower:.4g} A in the lower coil; K_s {point.k_s:.4g} N/m, K_i {point.k_i:.4g} N/A"
    )
    if is_drawn:
        click.echo(
            f"the poles of this magnet are assumed to lie at radii from {1e3 * magnet.inner_radius:.3g} to "
            f"{1e3 * magnet.outer_radius:.3g} mm of {axis.at}, the nearest part; enter yours in [thrust_bearing] of "
            "machine.toml"
        )


def _magnet(
    k_i: str | None, k_s: str | None, gap: str | None, bias: str | None, drive: Drive | None
) -> MagnetData | None:
    """Return the magnet's constants from a data sheet, or None if the user gives no constants."""
    from amb_assessment.first_design.sizing import MagnetData
    from amb_cosim.cosim.system.values import quantity

    if k_i is None and k_s is None:
        if bias or drive:
            raise ValueError("--bias and --drive require --k-i and --k-s from a data sheet")
        return None
    if k_i is None or k_s is None:
        raise ValueError("--k-i and --k-s must be set together")
    return MagnetData(
        quantity(k_i, "N/A", "k-i"),
        quantity(k_s, "N/m", "k-s"),
        None if gap is None else quantity(gap, "m", "gap"),
        None if bias is None else quantity(bias, "A", "bias"),
        drive or "differential",
    )


def _assumed(magnet: MagnetData) -> str:
    """Return the assumptions about a magnet that is described by a data sheet."""
    constants = "K_i and K_s are values without load"
    if magnet.keeps_k_s:
        constants = (
            "K_i and K_s are taken as values under load, and the gap is assumed; if they are values without load, "
            "set --gap or --bias"
        )
    elif magnet.gap is None and magnet.bias is None:
        constants += ", and the gap is assumed"
    sharing = "both coils share the load" if magnet.drive == "differential" else "the upper coils carry the load"
    return f"magnet of the data sheet: {constants}; {sharing} ({magnet.drive} drive)"


def _echo_design(name: str, design: Design) -> None:
    """Print the behaviour of the levitated machine, the targets that it misses, and its gains."""
    loop, pid = design.loop, design.pid
    click.echo(
        f"{name} does not levitate: {loop.least_damped}"
        if design.refusal
        else f"{name} levitates: sensitivity at most {loop.peak.value:.3g}, zone {loop.zone} of ISO 14839-3 "
        f"({loop.peak.axis}, {loop.peak.frequency:.0f} Hz), and {loop.peak_beyond.value:.3g} above 2 kHz; damping "
        f"ratios at least {loop.damping}"
    )
    for shortfall in design.shortfalls:
        click.echo(f"target missed: {shortfall}")
    if design.shortfalls:
        click.echo(
            "for controllers other than a PID, see docs/how-to/find_a_controller.md (examples/controllers/search.py)"
        )
    click.echo(f"sample time: {1e6 * design.sample_time:g} µs")
    for other in design.rejected:
        lacks = "; ".join(other.shortfalls) or "it is further from its targets"
        click.echo(f"sample time rejected: {1e6 * other.sample_time:g} µs: {lacks}")
    for bearing, k_b in pid.k_b.items():
        click.echo(f"bearing {bearing}: K_b = {k_b:.3g} N/m, C_b = {pid.c_b[bearing]:.3g} N s/m in the closed loop")


def _lag(design: Design, bandwidth: float) -> str:
    """Return the assumed lags of amplifier, filter and computer for the vibration with the least margin to its target.

    A first-order amplifier lags by atan(f/f_b). A demand that is delayed by one sample and then held for one sample
    lags by 1.5 T.
    """
    omega, sample_time = design.loop.frequency, design.sample_time
    hertz = omega / (2.0 * math.pi)
    amplifier, computer = math.degrees(math.atan(hertz / bandwidth)), 540.0 * hertz * sample_time
    return (
        f"assumed lag at {hertz:.0f} Hz: {amplifier:.0f} deg from amplifiers of {1e-3 * bandwidth:.3g} kHz, "
        f"{computer:.0f} deg from a computer with a sample time of {1e6 * sample_time:g} µs and a delay of one sample, "
        "none from sensor filters"
    )


def _comparison(magnet: MagnetData | None, typical: MagnetData, lying: MagnetData) -> str:
    """Return text on the constants of a magnet sized for the rotor; it questions a very different data sheet.

    The magnets of a tilted shaft carry less of the weight, but real ones are often as large as those of a lying one.
    Therefore, no constants between those of the two are questioned.
    """
    if magnet is None:
        return ""
    text = f"; a magnet sized for this rotor would have K_s {typical.k_s:.4g} N/m, K_i {typical.k_i:.4g} N/A"
    low, high = sorted((typical.k_i, lying.k_i))
    if high > 1.01 * low:
        text += f", or for a horizontal shaft K_s {lying.k_s:.4g} N/m, K_i {lying.k_i:.4g} N/A"
    ratio = max(magnet.k_i / high, low / magnet.k_i)
    return (
        f"{text}; the values of K_i differ by a factor of {ratio:.2g}: is the data sheet for an axis or for a pole?"
        if ratio > APART
        else text
    )


def _asked(option: str, kind: click.ParamType[Any]) -> str:
    """Prompt for a missing value, or raise a ValueError if there is no terminal."""
    if not sys.stdin.isatty():
        raise ValueError(f"--{option} is missing")
    return str(click.prompt(option.capitalize(), type=kind))


def _rotor_text(name: str, rotor: str | None, mass: str | None, length: str | None, Omega: float) -> str:
    """Return the text of the named rotor file, or of a rotor file for a plain shaft."""
    from amb_assessment.first_design.rotor_text import plain_shaft
    from amb_cosim.cosim.system.values import quantity
    from amb_files.toml import read_text
    from rotor_analysis.packaged_rotors import rotor_path

    if rotor is None:
        m = quantity(mass or _asked("mass", WithUnit("60 kg")), "kg", "mass")
        return plain_shaft(name, m, quantity(length or _asked("length", WithUnit("1.2 m")), "m", "length"), Omega)
    for key, values in (("mass", mass), ("length", length)):
        if values is not None:
            raise ValueError(
                f"{key} = {values!r} conflicts with the rotor file, which already states this value; set "
                f"only one of them"
            )
    path = rotor_path(rotor)
    warn_of_sizes(path)  # errors name this file
    return read_text(path, f"rotor file {path}")


main.add_section("Design and judge", new)
main.add_examples(
    {
        "new": (
            "new pump --mass '60 kg' --length '1.2 m' --speed '12000 rpm'",
            "new blower --rotor drawing.toml --speed '12000 rpm'",
            "new fan --rotor f.toml --speed 9000rpm --tilt 90deg --thrust-disc",
        )
    }
)
