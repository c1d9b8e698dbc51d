"""First designs of machines: dimensions and files, levitation, landing and relevitation."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
import tomli_w
from click.testing import CliRunner
from strange_machine import DRAWING
from strange_machine import ROTOR as EXPANDER

import amb_cosim
from amb_analysis import studies
from amb_analysis.machine.axis_capability import load_capacity
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.first_design import files
from amb_assessment.first_design.design import Design
from amb_assessment.first_design.files import TEMPLATES, NotLevitated, new_machine
from amb_assessment.first_design.levitation import lead_unit, operating_points, pid_of
from amb_assessment.first_design.rotor_text import gap_for, plain_shaft, supports
from amb_assessment.first_design.sizing import CAPACITY, bandwidth_for, machine_sizes, sample_times_for
from amb_cosim.commands.cli import main
from amb_cosim.cosim.system.values import quantity
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.reduced_rotor import reduced_rotor, whirl_error
from rotor_analysis.rotor import ReductionOptions
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.static_load import carried_masses
from tests.support.messages import assert_names, raises_naming

RPM = math.pi / 30.0
MACHINES = {"blower": (12.0, 0.6, 30000.0), "pump": (60.0, 1.2, 12000.0), "turbine": (1500.0, 3.2, 6000.0)}
SCENARIOS = ("levitation", "runup", "landing", "relevitation", "sensor_loss", "shock")


def shaft_of(name):
    """Rotor file of a machine's plain shaft, and its speed."""
    mass, length, rpm = MACHINES[name]
    return plain_shaft(name, mass, length, rpm * RPM), rpm * RPM


@pytest.fixture
def undesigned(monkeypatch):
    """`undesigned(*arguments, **options)`: sizes and scenario of a machine for which no gains are found."""

    def sized(*arguments, **options):
        seen = []

        def refuse(sizes, scenario, *_, **__):
            k_s = {bearing: point.k_s for bearing, point in operating_points(sizes).items()}
            seen.extend((sizes, scenario(Design(1e-4, pid_of(k_s, [1.0, 1.0] * len(k_s) + [0.2], 1e-4)))))
            raise ValueError("no gains")

        monkeypatch.setattr(files, "first_design", refuse)
        with pytest.raises(ValueError, match="no gains"):
            new_machine(*arguments, **options)
        return seen

    return sized


def test_a_machine_is_designed_before_its_files_exist(tmp_path, undesigned):
    """The design has the rotor with its bearings as such, and a machine that cannot be designed leaves no file."""
    _, scenario = undesigned(tmp_path / "fans" / "fan", *shaft_of("pump"))
    assert [bearing.name for bearing in scenario.rotor.bearings] == ["left", "right"]
    assert not any(tmp_path.iterdir())


def test_plant_of_a_new_machine_whirls_at_its_trip_speed_as_all_elements(tmp_path, undesigned):
    """Modes at rest and residual shapes of its sites alone would tilt 0.4 % too fast."""
    speed = 90000.0 * RPM
    rotor = undesigned(tmp_path / "fan", plain_shaft("fan", 0.5, 0.2, speed), speed)[0].rotor
    error = whirl_error(rotor, 1)
    assert error.speed == pytest.approx(1.05 * speed, rel=1e-4)
    assert max(abs(value) for value in (*error.forward_error, *error.backward_error)) < 0.1
    at_rest = replace(rotor, reduction=ReductionOptions())
    assert reduced_rotor(at_rest).model.size < reduced_rotor(rotor).model.size


@pytest.mark.parametrize(
    ("given", "tried"),
    [((), (50e-6, 25e-6)), (("--sample-time", "100 us"), (100e-6,)), (("--sample-time", "0 s"), None)],
)
def test_a_stated_sample_time_is_the_only_one_tried(tmp_path, monkeypatch, given, tried):
    seen = []

    def refuse(sizes, scenario, options, progress, sample_times):
        seen.append(sample_times)
        raise ValueError("no gains")

    monkeypatch.setattr(files, "first_design", refuse)
    pump = ("--mass", "60 kg", "--length", "1.2 m", "--speed", "12000 rpm")
    done = CliRunner().invoke(main, ["new", str(tmp_path / "pump"), *pump, *given])
    if tried is None:
        assert_names(done.stderr, "sample time", "0 us", ">= 1 us")
    else:
        (times,) = seen
        assert times == pytest.approx(tried)


def sizes_of(tmp_path, name, bearings=None, gap=None, **stated):
    text, speed = shaft_of(name)
    file = tmp_path / "rotor.toml"
    file.write_text(text)
    file.write_text(text + supports(load_rotor(file), bearings, gap=gap))
    return machine_sizes(load_rotor(file), speed, gap=gap, **stated)


@pytest.fixture(scope="module")
def pump(tmp_path_factory):
    return new_machine(tmp_path_factory.mktemp("new") / "pump", *shaft_of("pump"))


@pytest.fixture(scope="module")
def expander(tmp_path_factory):
    """The expander with magnets by `new`; its guide is passive."""
    folder = tmp_path_factory.mktemp("new") / "expander"
    return new_machine(folder, DRAWING, 15000.0 * RPM, sample_time=25e-6)


def is_late(made):
    """Return whether the demands of a machine's scenario come a sample late, with which its loop must be stable."""
    return load_scenario(str(made.folder / "levitation.toml")).parameters["rolac_controller"]["chain.delay"] is True


@pytest.mark.parametrize("name", MACHINES)
def test_magnets_carry_the_weight_with_a_margin(tmp_path, name):
    sizes = sizes_of(tmp_path, name)
    assert math.sqrt(2.0) * sum(sizes.loads.values()) == pytest.approx(9.81 * MACHINES[name][0], rel=1e-4)
    for bearing, point in operating_points(sizes).items():
        names = ("turns", "pole_area", "gap", "bias_current", "current_limit")
        axis = axis_parameters(**{name: getattr(sizes, name) for name in names}, static_current=0.0)
        load = sizes.loads[bearing]
        assert load_capacity(axis, np.array([load])).up[0] > (CAPACITY - 1.0) * load
        assert 0.0 < point.static_current < sizes.bias_current


def test_bearings_share_the_weight_by_the_levers_of_statics(tmp_path):
    left, right = sizes_of(tmp_path, "pump", (0.2, 0.9)).loads.values()
    centre = (left * 0.2 + right * 0.9) / (left + right)
    assert centre == pytest.approx(0.7 * 0.6 + 0.3 * 0.45 * 1.2, rel=1e-4)


@pytest.mark.parametrize("degrees", [-90.0, -30.0, 0.0, 30.0, 60.0, 90.0])
def test_magnets_of_a_tilted_shaft_carry_the_weight_across_it(tmp_path, degrees):
    sizes, lying = (sizes_of(tmp_path, "pump", tilt=math.radians(angle)) for angle in (degrees, 0.0))
    share = abs(math.cos(math.radians(degrees)))
    assert list(sizes.loads.values()) == pytest.approx([share * load for load in lying.loads.values()], abs=1e-9)
    assert (max(sizes.loads.values()) == 0.0) == (abs(degrees) == 90.0)  # exactly, not by rounding
    assert sizes.pole_area > 0.0


@pytest.mark.parametrize("gap", [0.25e-3, 0.5e-3, 2e-3])
def test_a_stated_gap_is_that_of_the_magnets_and_twice_the_clearance(tmp_path, gap):
    sizes = sizes_of(tmp_path, "pump", gap=gap)
    assert (sizes.gap, sizes.clearance) == pytest.approx((gap, 0.5 * gap))


def test_a_gap_that_is_no_wider_than_the_retainers_is_refused(tmp_path):
    sizes = sizes_of(tmp_path, "pump")
    with raises_naming(ValueError, "gap", f"{sizes.clearance:.4g} m", "retainer"):
        machine_sizes(sizes.rotor, sizes.speed, gap=sizes.clearance)


@pytest.mark.parametrize("degrees", [30.0, 90.0])
def test_files_of_a_tilted_machine_have_its_gravity(tmp_path, undesigned, degrees):
    _, scenario = undesigned(tmp_path / "fan", *shaft_of("pump"), tilt=math.radians(degrees))
    assert quantity(scenario.gravity, "m/s2", "gravity") == pytest.approx(9.81)
    assert quantity(scenario.tilt, "rad", "tilt") == pytest.approx(math.radians(degrees))


def test_magnets_carry_at_speed_what_a_passive_bearing_leaves_and_all_of_it_at_rest(tmp_path):
    """A seal between the magnets, stiffer than the shaft, but at speed alone: capacity is that at rest."""
    text, speed = shaft_of("pump")
    (tmp_path / "bare.toml").write_text(text)
    text += supports(load_rotor(tmp_path / "bare.toml"), (0.2, 0.9))
    seal = '[[seals]]\nname = "guide"\nz = 0.55\n' + "".join(
        f"[[seals.at_speed]]\nspeed = '{at} rad/s'\nstiffness = {k}\n" for at, k in ((0.0, 0.0), (speed, 1e12))
    )
    sizes = []
    for name, content in (("plain", text), ("sealed", text + seal)):
        (tmp_path / f"{name}.toml").write_text(content)
        sizes.append(machine_sizes(load_rotor(tmp_path / f"{name}.toml"), speed))
    plain, sealed = sizes
    middle = replace(
        sealed.rotor, seals=(), bearings=(*sealed.rotor.bearings, replace(sealed.rotor.seals[0], at_speed=()))
    )
    for bearing, load in sealed.loads.items():
        assert load == pytest.approx(carried_masses(middle)[bearing] * 9.81 / math.sqrt(2.0), rel=1e-3)
        assert load < plain.loads[bearing]
    assert sealed.pole_area == pytest.approx(plain.pole_area, rel=1e-6)


def test_every_file_of_a_new_machine_can_be_read(pump):
    assert {file.name for file in pump.folder.iterdir()} == {"rotor.toml", *(file.name for file in TEMPLATES.iterdir())}
    for name in SCENARIOS:
        scenario = load_scenario(str(pump.folder / f"{name}.toml"))
        assert "pump" in scenario.description
        assert load_rotor(scenario.rotor).name == "pump"


def test_bandwidth_and_signal_chain_of_a_new_machine_are_in_its_file(pump):
    text = (pump.folder / "levitation.toml").read_text(encoding="utf-8")
    parameters = tomllib.loads(text.replace('# "chain.', '"chain.'))["parameters"]
    assert parameters["amb_actuator"]["*.bandwidth_?"] == "1.4 kHz"
    assert {"chain.noise", "chain.adc", "chain.delay", "chain.sensitivity"} <= {*parameters["rolac_controller"]}


def test_a_new_machine_levitates_clear_of_its_retainers(pump):
    """No vibration of its loop grows, and a run of the scenario agrees: orbits stay within a sixth of the clearance."""
    assert is_late(pump)
    assert pump.design.loop.is_stable
    assert pump.design.loop.zone in "AB"
    result = amb_cosim.run(load_scenario(str(pump.folder / "levitation.toml")).changed(settle_cycles=20, end_time=0.05))
    assert result.outcome.status == "completed"
    assert all(orbit < 0.17e3 * pump.sizes.clearance for orbit in result.summary.orbit_largest.values())


@pytest.mark.slow
def test_unbalance_peaks_at_the_critical_speeds_of_the_sampled_loop(pump):
    """Response by frequency and eigenvalues of the sampled loop are computed independently; AF = 1/(2 zeta)."""
    scenario = pump.folder / "levitation.toml"
    response = studies.unbalance_response(scenario=scenario)
    assert response.stable_up_to is None  # up to the end of the range
    for c_b in (1.2e3, 2e5):  # hardly any damping of the rigid rotor; a high bending mode is driven
        with raises_naming(ValueError, "not stable", "vibration"):
            studies.unbalance_response(scenario=scenario, set={"rolac_controller.*.c_b_?": c_b})
    soft = studies.unbalance_response(scenario=scenario, set={"rolac_controller.*.c_b_?": 1.8e3})
    assert soft.stable_up_to == soft.speeds[-1]  # above it, the rotor's own damping drives its whirl
    assert_names(str(soft), "not stable above")
    sharp = [item for item in response.critical_speeds if item.amplification > 3.0]
    assert sharp
    crossings = studies.poles(scenario, up_to=float(response.speeds[-1])).critical_speeds
    for item in sharp:
        nearest = min(crossings, key=lambda crossing: abs(crossing.speed - item.speed))
        assert item.speed == pytest.approx(nearest.speed, rel=0.01)
        assert item.amplification == pytest.approx(np.pi / nearest.decrement, rel=0.1)
        assert item.margin == pytest.approx(100.0 * (item.speed / response.operating_speed - 1.0))
    half = studies.unbalance_response(scenario=scenario, unbalance=0.5 * response.unbalance)
    assert half.critical_speeds[0].amplitude == pytest.approx(0.5 * response.critical_speeds[0].amplitude)


def test_magnets_are_placed_in_the_bearings_of_a_drawing(expander):
    """Names, positions and clearances of the drawing stay; the orbit of a run is within a tenth of the clearance."""
    rotor = load_rotor(expander.folder / "rotor.toml")
    assert (expander.folder / "rotor.toml").read_text() == DRAWING
    assert list(expander.points) == [bearing.name for bearing in rotor.bearings] == ["north", "south"]
    assert expander.sizes.gap == pytest.approx(2.0 * rotor.sites[0].clearance)
    assert is_late(expander)
    assert expander.design.loop.is_stable
    result = amb_cosim.run(
        load_scenario(str(expander.folder / "levitation.toml")).changed(settle_cycles=20, end_time=0.02)
    )
    assert result.outcome.status == "completed"
    assert 0.0 < max(result.summary.orbit_largest.values()) < 0.1e3 * expander.sizes.clearance


def test_damping_missing_in_a_drawing_is_assumed_and_reported(tmp_path):
    """Without damping, sampled control drives the high bending modes of many rotors; stated damping stays."""
    lines = DRAWING.split("\n")
    begin = lines.index("[damping]")
    after = next((k for k in range(begin + 1, len(lines)) if lines[k].startswith("[")), len(lines))
    undamped = tmp_path / "undamped.toml"
    undamped.write_text("\n".join(lines[:begin] + lines[after:]))
    assert not any(load_rotor(undamped).damping.ratios(3))
    done = CliRunner().invoke(main, ["new", str(tmp_path / "made"), "--rotor", str(undamped), "--speed", "15000 rpm"])
    assert_names(done.stdout.splitlines()[0], "made", "levitates")  # the answer first
    assert_names(done.output, "sample time: 25 µs", "50 µs", "zone A ends at 3", "2.73 A", "15750 rpm", "current_limit")
    assert_names(done.output, "damping", "assumed", "[reduction]", "speed = '15750 rpm'")
    assert load_rotor(tmp_path / "made/rotor.toml").damping.ratios(3).tolist() == [0.003, 0.005, 0.01]


def test_the_scenarios_of_a_drawing_act_on_its_parts(expander):
    inputs = {name: load_scenario(str(expander.folder / f"{name}.toml")) for name in SCENARIOS}
    assert inputs["levitation"].inputs["rotor_contact"]["turbine.u"]
    assert inputs["sensor_loss"].event[0].set["rolac_controller"] == {"north_east.fault_dead": True}
    races = {"catch_n.race_inertia", "catch_s.race_inertia", "catch_n.race_drag", "catch_s.race_drag"}
    assert set(load_machine(expander.folder / "machine.toml").parameters["rotor_contact"]) == races


@pytest.mark.slow
def test_the_drawing_of_a_compressor_lands_and_is_lifted_off(tmp_path):
    drawing = rotor_path("compressor").read_text(encoding="utf-8")
    made = new_machine(tmp_path / "compressor", drawing, 9000.0 * RPM)
    assert made.design.loop.holds
    assert amb_cosim.run(str(made.folder / "relevitation.toml")).summary.recovery == "recovered"


LACKING = {"sensors": "a sensor", "bodies": "a plane of unbalance"}


@pytest.mark.parametrize("key", LACKING)
def test_error_names_the_part_that_a_drawing_lacks(tmp_path, key):
    drawing = tomllib.loads(EXPANDER.read_text(encoding="utf-8"))
    del drawing[key]
    with pytest.raises(ValueError, match=f"rotor 'expander' lacks {LACKING[key]}; its file needs"):
        new_machine(tmp_path / "fan", tomli_w.dumps(drawing), 1000.0)
    assert list(tmp_path.iterdir()) == []


def test_a_rotor_that_no_pid_holds_is_refused_with_its_unstable_mode(tmp_path):
    """An undamped shaft whose sensors are beyond nodes of its bending modes: no PID stabilises it."""
    text = shaft_of("pump")[0].replace("modal = [0.003, 0.005, 0.01]", "modal = 0.0")
    places = "".join(f'[[bearings]]\nname = "{b}"\nz = {z}\nstiffness = 1e6\n' for b, z in (("a", 0.1), ("b", 1.1)))
    sites = "".join(f'[[sites]]\nname = "r{b}"\nz = {z}\nbearing = "{b}"\n' for b, z in (("a", 0.15), ("b", 1.05)))
    sensors = '[[sensors]]\nname = "sa"\nz = 0.34\n[[sensors]]\nname = "sb"\nz = 0.86\n'
    folder = tmp_path / "fan"
    with raises_naming(
        NotLevitated, "none of the PIDs", "grows", "bending mode 1", "node", "sb", str(folder)
    ) as caught:
        new_machine(folder, "\n".join((text, places, sites, sensors)), 12000.0 * RPM, sample_time=50e-6)
    page = (folder / "README.md").read_text(encoding="utf-8")
    assert_names(page, "does not levitate", "bending mode 1", "node", "sb")
    stated = load_scenario(str(folder / "levitation.toml")).parameters["rolac_controller"]
    k_b = caught.value.machine.design.pid.k_b
    assert {b: quantity(stated[f"{b}.k_b_?"], "N/m", b) for b in k_b} == pytest.approx(k_b, rel=1e-4)


def test_what_is_assumed_follows_the_speed_beyond_usual_machines():
    """A full swing reaches twice the speed, and a turn has 24 samples; up to 42,000 rpm, 1.4 kHz and 50 us suffice."""
    for rpm in (1500.0, 12000.0, 42000.0):
        assert bandwidth_for(rpm * RPM) == pytest.approx(1400.0)
        assert sample_times_for(rpm * RPM) == (50e-6, 25e-6)
    for rpm in (90000.0, 500000.0):
        assert bandwidth_for(rpm * RPM) == pytest.approx(2.0 * rpm / 60.0)
        longest, shorter = sample_times_for(rpm * RPM)
        assert 24.0 <= 60.0 / rpm / longest < 48.0
        assert shorter == 0.5 * longest


def test_air_gap_of_thin_and_of_thick_shafts_keeps_its_share_of_the_diameter():
    assert [gap_for(d) for d in (0.05, 0.1, 0.2, 0.4)] == pytest.approx([0.3e-3, 0.4e-3, 0.8e-3, 1e-3])
    assert gap_for(4e-3) == pytest.approx(4e-3 / 40.0)
    assert gap_for(1.0) == pytest.approx(2e-3)


@pytest.mark.parametrize(
    ("mass", "length", "rpm", "voltage"),
    [(60.0, 1.2, 12000.0, 130.0), (1500.0, 3.2, 6000.0, 600.0), (5e4, 8.0, 3e3, None), (5e-3, 0.03, 5e5, 50.0)],
)
def test_heavy_rotors_have_amplifiers_of_more_current_and_light_ones_of_less(tmp_path, mass, length, rpm, voltage):
    """B = mu_0 N (2 I_b)/s_0 = 1.2 T; from 10 A, the current grows until 600 V suffice, and falls until 50 V do."""
    file, speed = tmp_path / "rotor.toml", rpm * RPM
    file.write_text(plain_shaft("rotor", mass, length, speed))
    file.write_text(file.read_text() + supports(load_rotor(file), None))
    sizes = machine_sizes(load_rotor(file), speed)
    assert 4e-7 * math.pi * sizes.turns * 2.0 * sizes.bias_current / sizes.gap == pytest.approx(1.2, rel=0.05)
    assert sizes.bias_current == pytest.approx(0.4 * sizes.current_limit)
    inductance = 8e-7 * math.pi * sizes.turns**2 * sizes.pole_area / sizes.gap
    assert sizes.inductance == pytest.approx(inductance, rel=1e-6)
    needed = 2.0 * sizes.resistance * sizes.current_limit + 2.0 * inductance * sizes.bias_current * speed
    assert needed <= sizes.voltage_limit <= needed + 10.0
    if voltage is None:
        assert sizes.current_limit > 90.0
    else:
        assert sizes.voltage_limit <= voltage


def test_leads_of_the_search_follow_the_rate_at_which_magnets_pull_the_rotor_away(tmp_path):
    """Of usual machines, they are in milliseconds; a rotor of a few grams leaves its centre several times as fast."""
    assert [lead_unit(sizes_of(tmp_path, name)) for name in MACHINES] == [1e-3] * len(MACHINES)
    speed = 500000.0 * RPM
    file = tmp_path / "tiny.toml"
    file.write_text(plain_shaft("tiny", 5e-3, 0.03, speed))
    file.write_text(file.read_text() + supports(load_rotor(file), None))
    sizes = machine_sizes(load_rotor(file), speed)
    k_s = max(point.k_s for point in operating_points(sizes).values())
    assert lead_unit(sizes) == pytest.approx(1.0 / math.sqrt(k_s / (0.5 * sizes.mass)), rel=1e-6)
    assert lead_unit(sizes) < 0.5e-3


def test_a_stated_bandwidth_is_that_of_every_amplifier(tmp_path, undesigned):
    _, scenario = undesigned(tmp_path / "fan", *shaft_of("pump"), bandwidth=3000.0)
    assert scenario.parameters["amb_actuator"]["*.bandwidth_?"] == "3 kHz"
    with raises_naming(ValueError, "bandwidth", "1 Hz", ">= 10 Hz"):
        new_machine(tmp_path / "other", *shaft_of("pump"), bandwidth=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["blower", "pump"])
def test_a_new_machine_lands_and_is_lifted_off_again(tmp_path, name):
    made = new_machine(tmp_path / name, *shaft_of(name))
    landed = amb_cosim.run(str(made.folder / "relevitation.toml"))
    assert landed.summary.recovery == "recovered"
    shaken = amb_cosim.run(str(made.folder / "shock.toml"))
    assert shaken.summary.recovery in ("prevented", "recovered")


@pytest.mark.parametrize(
    ("given", "bearings", "facts"),
    [
        ((0.0, 1.0, 100.0), None, ("mass", "0 kg")),
        ((60.0, math.nan, 100.0), None, ("length", "nan m")),
        ((60.0, 1.2, -1.0), None, ("speed", "-9.549 rpm")),
        ((60.0, 0.5, 60000.0 * RPM), None, ("speed", "60000 rpm", "<= 32725 rpm", "surface")),
        ((600.0, 0.5, 100.0), None, ("quarter",)),
        ((60.0, 1.2, 100.0), (0.9, 0.2), ("bearings", "0.9 m, 0.2 m")),
    ],
)
def test_values_of_which_no_machine_can_be_made_are_refused(tmp_path, given, bearings, facts):
    with raises_naming(ValueError, *facts):
        new_machine(tmp_path / "fan", plain_shaft("fan", *given), given[2], bearings)


def test_an_existing_folder_is_not_overwritten(tmp_path):
    with pytest.raises(ValueError, match="exists"):
        new_machine(tmp_path, *shaft_of("pump"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("given", ["0.2 m", "0.2m 0.5 m, 0.9 m"])
def test_bearings_that_are_not_two_positions_are_refused(tmp_path, given):
    requested = ("new", str(tmp_path / "fan"), "--mass", "60 kg", "--length", "1.2 m", "--speed", "200 Hz")
    assert "two positions" in CliRunner().invoke(main, [*requested, "--bearings", given]).stderr


def test_the_machine_to_assess_lands_in_the_retainers_of_its_landing(pump):
    landing = load_scenario(str(pump.folder / "landing.toml")).parameters["rotor_contact"]
    machine = load_machine(pump.folder / "machine.toml").parameters["rotor_contact"]
    assert {name: landing[name] for name in machine} == machine


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        (("--mass", "60 kg"), ("mass", "'60 kg'", "rotor file")),
        (("--bearings", "0.1 m 0.3 m"), ("rotor file", "north at 0.11 m", "guide at 0.22 m", "south at 0.32 m")),
        (("--speed", "1500000 rpm"), ("speed", "1500000 rpm", "<= 907183 rpm", "954930 rpm")),
        (("--rotor", "expandor"), ("'expandor'", "turbo_expander")),
    ],
)
def test_options_that_conflict_with_a_rotor_file_are_refused(tmp_path, given, facts):
    requested = ("new", str(tmp_path / "fan"), "--rotor", str(EXPANDER), "--speed", "15000 rpm", *given)
    done = CliRunner().invoke(main, requested)
    assert done.exit_code == 2, done.stderr
    assert_names(done.stderr, *facts)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ['a"b', "a\nb", "a\\b", 'a"\n[materials]', "a\x7f"])
def test_a_name_that_a_file_cannot_hold_is_refused(name, tmp_path):
    from_mass = ["--mass", "60 kg", "--length", "1 m"]
    for values in (from_mass, ["--rotor", str(EXPANDER)]):
        done = CliRunner().invoke(main, ["new", str(tmp_path / name), *values, "--speed", "9000 rpm"])
        assert done.exit_code == 2
        assert_names(done.stderr, "name", f"{name!r}", "printable")
    assert [*tmp_path.iterdir()] == []
