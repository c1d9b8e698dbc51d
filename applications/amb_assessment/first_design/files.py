"""The files of a new machine, which are templates with the sizes filled in; their folder is created atomically."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from string import Template

from amb_assessment.first_design import thrust
from amb_assessment.first_design.design import Design, Progress, first_design
from amb_assessment.first_design.levitation import TRIP, OperatingPoint, operating_points
from amb_assessment.first_design.rotor_text import damping, filled, reduction, require_name, supports
from amb_assessment.first_design.sizing import MachineSizes, MagnetData, machine_sizes, sample_times_for
from amb_assessment.first_design.whirl_onset import FRICTION, race_of, whirl_onset
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import RPM
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_cosim.scenario.scenario import Scenario, make_scenario
from amb_files.atomic import create_atomically
from amb_files.checks import require
from amb_files.toml import parse_toml
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import rotor_from

TEMPLATES = Path(__file__).parent / "templates"
ROTOR, LEVITATION = "rotor.toml", "levitation.toml"
WIDE = 0.1  # m, the widest gap
BANDWIDTHS = (10.0, 1e6)  # Hz, of the slowest and of the fastest amplifier
SAMPLED = (1e-6, 1e-2)  # s, the shortest and the longest sample time
LANDING = 0.5  # s, shortest landing
FALL = "landing.toml"  # the base scenario of those with a drop


@dataclass(frozen=True)
class NewMachine:
    """A written machine: its folder, its sizes, the operating points by bearing, and the design of the controller.

    typical, lying
        K_i and K_s of a magnet that is sized without a data sheet, for the tilt of the shaft and for a horizontal one.
    assumed
        Parts added to the rotor file: `bearings` (with retainers and sensors), `damping`, and `thrust_disc` (with
        faces).
    axis
        The magnet of the thrust disc, if there is one.
    """

    folder: Path
    assumed: tuple[str, ...]
    sizes: MachineSizes
    typical: MagnetData
    lying: MagnetData
    points: dict[str, OperatingPoint]
    design: Design
    axis: thrust.Thrust | None = None


class NotLevitated(ValueError):
    """No gains levitate a rotor; `machine` has been written with the gains that come closest."""

    def __init__(self, machine: NewMachine) -> None:
        super().__init__(f"{machine.design.refusal}; {machine.folder} has the design that comes closest")
        self.machine = machine


@one_blas_thread()
def new_machine(
    folder: Path,
    rotor: str,
    speed: float,
    bearings: tuple[float, float] | None = None,
    magnet: MagnetData | None = None,
    flavour: Flavour = "native",
    progress: Progress = lambda sample_time, tried: None,
    *,
    gap: float | None = None,
    tilt: float = 0.0,
    thrust_disc: bool = False,
    sample_time: float | None = None,
    bandwidth: float | None = None,
) -> NewMachine:
    """Write the rotor, scenarios, a machine file and a page about them into a new folder.

    The controller in the scenarios levitates the rotor. If the rotor has no retainers, no drop scenarios are written.

    Parameters
    ----------
    folder
        The folder to create; its name becomes the name of the machine.
    rotor
        Text of a rotor file, from `plain_shaft` or a drawing. If it lacks `[damping]`, a default is assumed. If it
        lacks `[reduction]`, a reduction is added that keeps the plant accurate up to the trip speed.
    speed
        Highest operating speed (rad/s).
    bearings
        Positions of two magnetic bearings (m), if the rotor file has no bearings; by default, `supports` places them.
    magnet
        K_i and K_s of the axes from a data sheet; by default, the magnets are designed.
    flavour
        Flavour of the FMUs that are linearised.
    progress
        Function that is called with a sample time and the number of sets of gains tried with it.
    gap, tilt
        Air gap of the magnets (m; by default as in `machine_sizes`), and angle of the shaft above the horizontal (rad;
        by default 0).
    thrust_disc
        Whether to add a thrust disc, and faces at the lower retainer, to a rotor file without a thrust disc.
    sample_time
        Sample time of the controller (s); by default the first of `sample_times_for` that reaches zone A.
    bandwidth
        Bandwidth of the amplifiers for small signals (Hz); by default `bandwidth_for` the speed.

    Raises
    ------
    ValueError
        If the folder exists or its name is not allowed in a TOML file, or if the rotor file is invalid or lacks parts
        that `machine_sizes` needs. The error is also raised if both `rotor` and `bearings` define bearings.
    NotLevitated
        If no gains levitate the rotor. The files are written with the gains that come closest, and state the reasons.
    """
    require_name(folder.name)
    require(abs(tilt) <= 0.5 * math.pi, "tilt", f"{math.degrees(tilt):g} deg", ">= -90 deg and <= 90 deg")
    require(gap is None or 0.0 < gap <= WIDE, "gap", f"{gap} m", f"> 0 m and <= {WIDE:g} m")
    slow, fast = BANDWIDTHS
    allowed = f">= {slow:g} Hz and <= {1e-3 * fast:g} kHz"
    require(bandwidth is None or slow <= bandwidth <= fast, "bandwidth", f"{bandwidth or 0.0:g} Hz", allowed)
    least, most = SAMPLED
    sampled = f">= {1e6 * least:g} us and <= {1e6 * most:g} us"
    if sample_time is not None:
        require(least <= sample_time <= most, "sample time", f"{1e6 * sample_time:g} us", sampled)
    if folder.exists():
        raise ValueError(f"{folder} exists; a new machine needs a new folder")
    name = f"rotor file {folder / ROTOR}"
    stated = parse_toml(rotor, name)
    has_damping = "damping" in stated
    rotor += "" if has_damping else damping()
    rotor += "" if "reduction" in stated else reduction(TRIP * speed)
    drawn = _rotor_of(rotor, name)
    if drawn.bearings and bearings:
        present = ", ".join(f"{b.name} at {drawn.shaft.nodes[b.node - 1]:g} m" for b in drawn.bearings)
        raise ValueError(
            f"bearing positions conflict with the rotor file, which has bearings {present}; omit one of the two"
        )
    stated_text = rotor if drawn.bearings else rotor + supports(drawn, bearings, gap=gap)
    supported, axial = _rotor_of(stated_text, name), ""
    if thrust_disc and not drawn.thrust:
        axial = thrust.disc_and_faces(supported, gap)
        supported = _rotor_of(stated_text + axial, name)
    whole, supported = supported, replace(supported, thrust_disc=None, faces=())  # the second for the radial design
    sizes = machine_sizes(supported, speed, magnet, gap=gap, tilt=tilt, bandwidth=bandwidth)
    points = operating_points(sizes)

    def values(design: Design) -> dict[str, str]:
        return _values(folder.name, sizes, points, design, tilt)

    def scenario(design: Design) -> Scenario:
        text, what = _filled(values(design), bool(sizes.retainers))[LEVITATION], f"scenario {folder / LEVITATION}"
        return make_scenario(parse_toml(text, what) | {"rotor": supported}, LEVITATION)

    sample_times = sample_times_for(speed) if sample_time is None else (sample_time,)
    design = first_design(sizes, scenario, RunOptions(flavour=flavour), progress, sample_times=sample_times)
    if not drawn.bearings:
        rotor += supports(drawn, bearings, design.pid.k_b, design.pid.c_b, gap)
    of_files, of_axis, axis = values(design), dict[str, str](), None
    if whole.thrust_disc is not None:
        axis = thrust.thrust_magnet(whole, sizes, tilt)
        of_files["control_file"] = f'\nfmu.rolac_controller = "{thrust.CONTROL}"'
        of_files["rolac_parameters"], of_files["rolac_inputs"] = thrust.limits(sizes, axis), ""
        of_files["of_magnets"] += axis.lines
        of_files["thrust_bearing"] = thrust.machine_part(axis, sizes.bandwidth)
        of_files["bearing_rows"] += f"\n{_row(axis.name, abs(axis.load), axis.coils, axis.point.k_s, axis.point.k_i)}"
        of_axis[thrust.CONTROL] = thrust.controller(folder.name, sizes, axis, design.pid, design.sample_time)
    files = {ROTOR: rotor + axial, **_filled(of_files, bool(sizes.retainers)), **of_axis}
    folder.parent.mkdir(parents=True, exist_ok=True)
    create_atomically(folder, lambda draft: [(draft / file).write_text(t, "utf-8") for file, t in files.items()])
    assumed = {"bearings": not drawn.bearings, "damping": not has_damping, "thrust_disc": bool(axial)}
    parts = tuple(part for part, is_assumed in assumed.items() if is_assumed)
    typical, lying = (machine_sizes(supported, speed, gap=gap, tilt=angle).magnet for angle in (tilt, 0.0))
    made = NewMachine(folder, parts, sizes, typical, lying, points, design, axis)
    if design.refusal:
        raise NotLevitated(made)
    return made


def _rotor_of(text: str, name: str) -> Rotor:
    """Return the rotor that a text describes."""
    return rotor_from(parse_toml(text, name), name)


def _filled(values: dict[str, str], falls: bool) -> dict[str, str]:
    """Return the templates with values filled in, by file name.

    If `falls` is false, the templates for falls onto retainers and all lines that name these templates are omitted.
    """
    texts = {file.name: file.read_text(encoding="utf-8") for file in sorted(TEMPLATES.iterdir())}
    omitted = set() if falls else {name for name, text in texts.items() if name == FALL or f'base = "{FALL}"' in text}
    result = {}
    for name in sorted(texts.keys() - omitted):
        lines = (line for line in texts[name].splitlines(True) if not any(file in line for file in omitted))
        result[name] = Template("".join(lines)).substitute(values)
    return result


def _coil_lines(sizes: MachineSizes) -> str:
    """Return the scenario lines of magnets whose upper coils carry I_0 + i_s and whose lower coils carry I_0 - i_s."""
    lines = []
    for bearing, coils in sizes.coils.items():
        values = {
            "bias_current": (coils.bias_current, "A"),
            "pole_area": (1e4 * coils.pole_area, "cm^2"),
            "inductance": (1e3 * sizes.inductance * coils.pole_area / sizes.pole_area, "mH"),
        }
        lines += [f'\n"{bearing}.{name}_?" = "{value:.6g} {unit}"' for name, (value, unit) in values.items()]
        shift = 0.5 * coils.static_current
        mean = coils.bias_current + shift
        lines[-3] += f"  # lower coils: {mean:.4g} A - {shift:.4g} A; upper coils: {mean:.4g} A + {shift:.4g} A"
    return "".join(lines)


def _first_bending(rotor: Rotor) -> float:
    """Return the first bending frequency of the free rotor (Hz)."""
    full = assemble(rotor)
    return float(free_modes(full.M[::2, ::2], full.K[::2, ::2])[0][0] / (2.0 * math.pi))


def _behaviour(design: Design) -> str:
    """Return the behaviour and shortfalls of a design's sampled loop as Markdown; empty before they are computed."""
    loop = design.levitation
    if loop is None:
        return ""
    if design.refusal:
        lines = (
            *design.shortfalls,
            *(f"{1e6 * other.sample_time:g} us: {'; '.join(other.shortfalls)}" for other in design.rejected),
        )
        return "\n".join((f"**This machine does not levitate**: {design.refusal}.", *(f"\n- {lack}" for lack in lines)))
    peak = loop.peak
    text = (
        f"The largest sensitivity of the sampled loop up to the trip speed is {peak.value:.3g}, zone {loop.zone} of "
        f"ISO 14839-3 ({peak.axis},\n{peak.frequency:.0f} Hz), and {loop.peak_beyond.value:.3g} above 2 kHz. The "
        f"smallest damping ratio of its vibrations is\n{loop.damping}."
    )
    return "\n".join((text, *(f"\n- {lack}" for lack in design.shortfalls)))


def _gravity(tilt: float) -> dict[str, str]:
    """Return the template values for gravity (m/s^2) and for the scenario line that sets the tilt (rad)."""
    degrees = round(math.degrees(tilt), 9)
    line = f'\ntilt = "{degrees:.9g} deg"  # angle of the shaft above the horizontal' if degrees else ""
    return {"gravity": f"{STANDARD_GRAVITY:.6g}", "of_tilt": line}


def _row(name: str, load: float, coils: tuple[float, float], k_s: float, k_i: float) -> str:
    """Return the page's row about the axes of a bearing: load (N), coil currents (A), K_s (N/m) and K_i (N/A)."""
    upper, lower = coils
    return f"| {name} | {load:.4g} N | {upper:.4g} A | {lower:.4g} A | {k_s:.4g} N/m | {k_i:.4g} N/A |"


def _values(
    name: str, sizes: MachineSizes, points: dict[str, OperatingPoint], design: Design, tilt: float
) -> dict[str, str]:
    """Return the values that are filled into the templates."""
    race = race_of(sizes.mass, sizes.diameter)
    races = [
        f'"{site.name}.race_inertia" = "{race.inertia:.5g} kg.m2"\n"{site.name}.race_drag" = "{race.drag:.5g} N.m"'
        for site in sizes.retainers
    ]
    onset = whirl_onset(sizes.mass, sizes.speed, sizes.clearance, race, tilt) if races else 0.0
    pid = design.pid
    gains = [f'"{b}.k_b_?" = "{k:.5g} N/m"\n"{b}.c_b_?" = "{pid.c_b[b]:.5g} N.s/m"' for b, k in pid.k_b.items()]
    rows = [_row(bearing, sizes.loads[bearing], p.coils, p.k_s, p.k_i) for bearing, p in points.items()]
    texts = {
        "name": name,
        "plane": sizes.plane.name,
        "sensor": sizes.rotor.sensors[0].x,
        "races": "\n".join(races),
        "friction": f'"*.mu" = {FRICTION}  # steel on steel, lubricated' if races else "# no retainers",
        "bearing_rows": "\n".join(rows),
        "of_magnets": _coil_lines(sizes),
        "gains": "\n".join(gains),
        "bearings": ", ".join(f"{b} {k:.3g} N/m and {pid.c_b[b]:.3g} N s/m" for b, k in pid.k_b.items()),
        "does": _behaviour(design),
        "of_limits": "".join(f'\n"{b}.i_max_?" = "{c.bias_current:.5g} A"' for b, c in sizes.coils.items()),
        "first_bending": f"{_first_bending(sizes.rotor):.0f}",
    }
    numbers = {
        "mass": sizes.mass,
        "rpm": sizes.speed * RPM,
        "whirl_onset": onset,
        "landing_end": max(LANDING, onset),
        "slow_rpm": 0.05 * sizes.speed * RPM,
        "least_rpm": 0.8 * sizes.speed * RPM,
        "derivative_time": 1e6 * pid.derivative_time,
        "cross_coupling": 0.01 * min(pid.k_b.values()),
        "clearance_mm": 1e3 * sizes.clearance,
        "sample_time": 1e6 * design.sample_time,
        "turns": sizes.turns,
        "pole_area": 1e4 * sizes.pole_area,
        "gap": 1e3 * sizes.gap,
        "bias_current": sizes.bias_current,
        "current_limit": sizes.current_limit,
        "resistance": sizes.resistance,
        "inductance": 1e3 * sizes.inductance,
        "voltage_limit": sizes.voltage_limit,
        "bandwidth": 1e-3 * sizes.bandwidth,
        "unbalance": 1e6 * sizes.unbalance,
        "drive_gain": 1e-3 * sizes.mass * sizes.diameter,
        "drive_torque": 0.1 * sizes.mass * sizes.diameter,
    }
    values = texts | _gravity(tilt) | {key: f"{value:.5g}" for key, value in numbers.items()}
    control = {"control_file": "", "thrust_bearing": ""}  # ROLAC in the scenario, and no axial bearing
    return values | control | {part: filled(f"{part}.toml", **values) for part in ("rolac_parameters", "rolac_inputs")}
