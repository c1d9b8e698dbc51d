"""Rotor files: errors name file, key, value and allowed range."""

import math

import pytest

from rotor_analysis.parts import Bearing, Body, Disc, Sensor, Site
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor, numbered_positions
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names, raises_naming

STEEL = {"youngs_modulus": 2e11, "density": 7800.0, "poissons_ratio": 0.3}
SHAFT = "[shaft]\nnodes = [0, 0.5, 1]\ndiameter = 0.05\nyoungs_modulus = 2e11\ndensity = 7800\npoissons_ratio = 0.3\n"


def loaded(tmp_path, text):
    path = tmp_path / "pump.toml"
    path.write_text(text, encoding="utf-8")
    return load_rotor(path)


def refused(tmp_path, text):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the callers compare messages
        loaded(tmp_path, text)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"rotor file {tmp_path / 'pump.toml'}: ") for line in lines)
    return [line.split(".toml: ", 1)[1] for line in lines]


def test_file_gives_the_rotor_that_it_describes(tmp_path):
    text = f"""
        name = "pump"
        bodies = [
            {{name = "impeller", node = 2, mass = 3, radius = 0.1, width = 0.02}},
            {{name = "coupling", node = 3, mass = 1.0, diametral_inertia = 0.01, polar_inertia = 0.02}},
        ]
        bearings = [{{name = "oil", node = 1, stiffness = [[1e6, -2e5], [3e5, 1e6]], damping = 100}}]
        sites = [{{name = "seal", node = 2}}]
        sensors = [{{name = "inlet", node = 1}}, {{name = "outlet", node = 3, x = "s3", y = "s4"}}]
        reduction = {{masters = [1, 2]}}
        {SHAFT}
    """
    assert loaded(tmp_path, text) == Rotor(
        "pump",
        Shaft((0.0, 0.5, 1.0), (0.05,), **STEEL),
        (Disc("impeller", 2, 3.0, 0.1, 0.02), Body("coupling", 3, 1.0, 0.01, 0.02)),
        (Bearing("oil", 1, ((1e6, -2e5), (3e5, 1e6)), ((100.0, 0.0), (0.0, 100.0))),),
        (Site("seal", 2),),
        (Sensor("inlet", 1, "inlet.x", "inlet.y"), Sensor("outlet", 3, "s3", "s4")),
        ReductionOptions("msdc", (1, 2)),
    )


TENSOR = "a finite number or [[xx, xy], [yx, yy]] of finite numbers"
RING = '[[bodies]]\nname = "ring"\n'
OIL = '[[bearings]]\nname = "oil"\nnode = 1\n'
FROZEN = '[[bearings]]\nname = "gland"\nnode = 2\nstiffness = 1e6\n'
OVER_SPEED = "at_speed = [{{speed = {}, stiffness = 1e6}}, {{speed = {}, stiffness = 2e6}}]"
SEAL = '[[sites]]\nname = "seal"\n'
INLET = '[[sensors]]\nname = "inlet"\n'


def with_ring(node, mass, radius):
    return RING + f"node = {node}\nmass = {mass}\nradius = {radius}\nwidth = 1"


@pytest.mark.parametrize(
    ("more", "facts"),
    [
        (with_ring(9, 1, 1), ("bodies[0].node (ring)", "9", "1 to 3")),
        (with_ring(0, 1, 1), ("bodies[0].node (ring)", "0", ">= 1")),
        (with_ring(1, -1, 1), ("bodies[0].mass (ring)", "-1 kg", ">= 0 kg")),
        (with_ring(1, 1, -1.0), ("bodies[0].radius (ring)", "-1.0 m", ">= 0 m")),
        (RING + "node = 1\nmass = 1\nradius = 1", ("bodies[0].width (ring)", "missing")),
        (RING + "node = 1\nmass = 1\npolar_inertia = 1", ("bodies[0].diametral_inertia (ring)", "missing")),
        (OIL + "stiffness = [1e6, 1e6]", ("bearings[0].stiffness (oil)", "[1000000.0, 1000000.0]", TENSOR)),
        (OIL + "damping = 'much'", ("bearings[0].damping (oil)", "'much'", TENSOR)),
        (OIL + "stiffness = '5 kN/mm'", ("bearings[0].stiffness (oil)", TENSOR, "in N/m, written without a unit")),
        (OIL + "damping = 1e30", ("bearings[0].damping (oil) = 1e+30 N s/m", "1e20")),
        (OIL + "stifness = 1e6", ("bearings[0].stifness (oil)", "stiffness")),
        (RING + "mass = 1\nradius = 1\nwidth = 1", ("bodies[0] (ring)", "node", "z")),
        (OIL + "z = 0.5", ("bearings[0] (oil)", "both", "node", "z")),
        (SEAL + "z = 1.5", ("sites[0].z (seal)", "1.5 m", "0 m to 1 m")),
        (OIL.replace("oil", "2nd"), ("bearings[0].name (2nd)", "letters", "digits")),
        (OIL + SEAL + "node = 1\nbearing = 'oli'", ("sites[0].bearing (seal)", "'oli'", "oil")),
        (
            SEAL + "node = 1\nx = 's1'",
            ("sites[0].x (seal)", "name, node, clearance, journal_radius, bearing, stator, z"),
        ),
        (INLET + "node = 7", ("sensors[0].node (inlet)", "7", "1 to 3")),
        (INLET + "node = 1\nx = 's 1'", ("sensors[0].x (inlet)", "'s 1'", "variable")),
        ("[reduction]\nmasters = 4", ("reduction.masters", "4", "list")),
        ("[reduction]\nmasters = [1, 7]", ("reduction.masters[1]", "7", "1 to 3")),
        ("[reduction]\nmasters = [1, 1]", ("reduction.masters", "[1, 1]", "repetition")),
        (OIL + "[reduction]\nmasters = [2]", ("reduction.masters", "[2]", "oil")),
        ("[reduction]\nmasters = [1]", ("reduction.masters", "[1]")),
        (SEAL + "z = -0.1", ("sites[0].z (seal)", "-0.1 m", "0 m to 1 m")),
        (OIL + "stiffness = 1e30", ("bearings[0].stiffness (oil)", "1e+30")),
        (OIL + "stiffness = nan", ("bearings[0].stiffness (oil)", "nan")),
        (with_ring(1, 1, 1) + "\npolar_inertia = 1", ("bodies[0].polar_inertia (ring)",)),
        ("[bodies]\nname = 'ring'", ("bodies", "a table")),
        ("[damping]\nrotating = -1", ("damping.rotating", "-1")),
        ("[damping]\nmodal = [0.01, 'much']", ("damping.modal", "'much'")),
        ("[mesh]\naccuracy = -1", ("mesh.accuracy", "-1")),
        ("[reduction]\nspeed = 9900.0", ("reduction.speed", "9900.0", "9900.0 rpm", "9900.0 rad/s")),
        ("[reduction]\nspeed = '9900'", ("reduction.speed", "9900", "9900 rpm", "9900 rad/s")),
        ("[reduction]\nspeed = '9900 m'", ("reduction.speed", "9900 m", "rpm, 1/min, Hz, rad/s")),
        (OIL + OVER_SPEED.format("0", "9000"), ("bearings[0].at_speed[1].speed", "9000", "9000 rpm", "9000 rad/s")),
        (OIL + "stiffness = 1e6\nwhirl_frequency = 75", ("bearings[0].whirl_frequency", "75", "75 rad/s")),
        ("[reduction]\nspeed = '-1 rpm'", ("reduction.speed", "-1 rpm", ">= 0")),
        ("[reduction]\nspeed = 'nan rpm'", ("reduction.speed", "nan rpm")),
        ("[reduction]\nmethod = 'msdc'\nmodes = 4", ("reduction.modes", "free_modes", "'msdc'")),
    ],
)
def test_mistake_in_a_part_is_named_with_its_key(tmp_path, more, facts):
    (line,) = refused(tmp_path, f'name = "pump"\n{SHAFT}{more}')
    assert_names(line, *facts)


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        ("0.5, 1]", "0.5]\ndensty = 1", ("shaft.densty", "density")),
        ("[0, 0.5, 1]", "[0, 1, 0.5]", ("shaft.nodes", "[0.0, 1.0, 0.5] m", "ascending, two or more")),
        ("diameter = 0.05", "diameter = [0.05, 0.0]", ("shaft.diameter[1]", "0.0 m", "> 0 m")),
        ("diameter = 0.05", "diameter = [1, 1, 1]", ("shaft.diameter", "[1.0, 1.0, 1.0] m", "one value", "2")),
        (
            "diameter = 0.05",
            "diameter = 0.05\ninner_diameter = 0.06",
            ("shaft.inner_diameter", "0.06 m", ">= 0 m", "< 0.05 m"),
        ),
        ("density = 7800", "density = inf", ("shaft.density", "inf kg/m3", "finite", ">= 0")),
        ("diameter = 0.05", "diameter = 0.05\nmaterial = 'steel'", ("shaft.youngs_modulus", "material")),
        ("poissons_ratio = 0.3", "poissons_ratio = 0.5", ("shaft.poissons_ratio = 0.5", "> -1", "< 0.5")),
        ("diameter = 0.05", "diameter = 1e30", ("shaft.diameter", "1e+30 m")),
        ("diameter = 0.05", "diameter = 'wide'", ("shaft.diameter", "'wide'")),
        ("nodes = [0, 0.5, 1]\ndiameter = 0.05", "sections = [3]", ("shaft.sections[0]", "3")),
        (
            "poissons_ratio = 0.3",
            "poissons_ratio = 0.3\ntheory = 'euler'",
            ("shaft.theory", "'euler'", "'timoshenko'", "'rayleigh'"),
        ),
    ],
)
def test_mistake_in_the_shaft_is_named_with_its_key(tmp_path, old, new, facts):
    (line,) = refused(tmp_path, 'name = "pump"\n' + SHAFT.replace(old, new))
    assert_names(line, *facts)


def test_all_mistakes_of_a_file_are_named_at_once(tmp_path):
    text = SHAFT.replace("density = 7800", "density = -1").replace("diameter = 0.05", "")
    mass, name, density, diameter = sorted(refused(tmp_path, text + with_ring(1, -1, 1)))
    assert_names(mass, "bodies[0].mass (ring)", "-1 kg", ">= 0 kg")
    assert_names(name, "name", "missing")
    assert_names(density, "shaft.density", "-1 kg/m3", ">= 0")
    assert_names(diameter, "shaft.diameter", "missing")


def test_rotor_made_in_python_is_checked_alike():
    with raises_naming(ValueError, "mass", "-1.0 kg", ">= 0 kg"):
        Disc("ring", 1, -1.0, 0.1, 0.1)
    with raises_naming(ValueError, "bearings[0].node (oil)", "3", "1 to 2"):
        Rotor("pump", Shaft((0.0, 1.0), (0.05,), **STEEL), (), (Bearing("oil", 3),))


@pytest.mark.parametrize(
    ("more", "key"),
    [
        (with_ring(1, 1, 1) + "\n" + OIL.replace("oil", "ring"), "bearings[0].name = 'ring'"),
        (INLET + 'node = 1\nx = "s1"\ny = "s1"', "sensors[0].y = 's1'"),
    ],
)
def test_a_duplicate_name_is_refused_at_the_second_part(tmp_path, more, key):
    (line,) = refused(tmp_path, f'name = "pump"\n{SHAFT}{more}')
    assert_names(line, key, "unique")


def test_equal_rotors_share_what_is_computed_once_for_a_rotor(tmp_path):
    """Also with materials by name and tensors from lists; another bearing is another rotor."""
    bearing = '[[bearings]]\nname = "oil"\nnode = 1\nstiffness = [[1e6, 0], [0, 1e6]]\n'
    steel = f"[materials.steel]\n{SHAFT.split('diameter = 0.05')[1]}"
    text = f'name = "pump"\n{steel}[shaft]\nnodes = [0, 0.5, 1]\ndiameter = 0.05\nmaterial = "steel"\n{bearing}'
    first, second, other = (loaded(tmp_path, each) for each in (text, text, text.replace("1e6", "2e6")))
    assert len({first, second, other}) == len({first, other}) == 2


def test_part_placed_by_z_gets_a_node_there(tmp_path):
    """The numbers in the file count the nodes that the file states; the rotor has one more."""
    parts = SEAL + "z = 0.3\n" + OIL + INLET + "z = 1.0\n" + with_ring(2, 1, 1) + "\n[reduction]\nmasters = [1, 3]"
    with raises_naming(ValueError, "reduction.masters", "[1, 3]", "sites: seal"):
        loaded(tmp_path, f'name = "pump"\n{SHAFT}{parts}')
    rotor = loaded(tmp_path, f'name = "pump"\n{SHAFT}{parts.replace("[1, 3]", "[]")}')
    assert rotor.shaft.nodes == (0.0, 0.3, 0.5, 1.0)
    assert (rotor.site_nodes, rotor.bearing_nodes, rotor.sensor_nodes, rotor.bodies[0].node) == ((2,), (1,), (4,), 3)
    assert all(part.z is None for part in (*rotor.sites, *rotor.sensors))


def test_node_numbers_count_the_nodes_of_the_file_alone(tmp_path):
    text = f'name = "pump"\n{SHAFT}{SEAL}z = 0.3\n[mesh]\naccuracy = 1e-2\n'
    rotor = loaded(tmp_path, text)
    assert len(rotor.shaft.nodes) > 4
    assert numbered_positions(tmp_path / "pump.toml") == (0.0, 0.5, 1.0)
    assert numbered_positions(rotor) == rotor.shaft.nodes


def test_position_within_a_nanometre_of_a_node_is_the_node(tmp_path):
    rotor = loaded(tmp_path, f'name = "pump"\n{SHAFT}{SEAL}z = 0.5000000001')
    assert rotor.shaft.nodes == (0.0, 0.5, 1.0)
    assert rotor.site_nodes == (2,)


FACE = """[thrust_disc]
z = 0.5
[[sites]]
name = "ring"
node = 1
[[faces]]
name = "seat"
node = 1
stops = "-z"
clearance = 2e-4
radius = 0.01
"""


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        ("radius = 0.01", "radius = 0.01\nretainer = 'rign'", ("faces[0].retainer (seat)", "'rign'", "ring")),
        ("2e-4", "-2e-4", ("faces[0].clearance (seat)", "-0.0002 m", "> 0 m")),
        ('"-z"', '"z"', ("faces[0].stops (seat)", "'z'", "'-z'", "'+z'")),
        ('"seat"', '"ring"', ("faces[0].name", "'ring'", "unique")),
        ('"seat"\nnode = 1', '"seat"\nz = 3.0', ("faces[0].z (seat)", "3.0 m", "on the shaft")),
        ("[thrust_disc]\nz = 0.5\n", "", ("faces", "[thrust_disc]")),
    ],
)
def test_mistake_in_a_face_is_named_with_its_key(tmp_path, old, new, facts):
    (line,) = refused(tmp_path, f'name = "pump"\n{SHAFT}{FACE}'.replace(old, new))
    assert_names(line, *facts)


@pytest.mark.parametrize("text", ["9900 rpm", "165 Hz", "9900 1/min", f"{330.0 * math.pi!r} rad/s"])
def test_speeds_of_a_rotor_have_a_unit_in_files_and_none_in_python(tmp_path, text):
    file = tmp_path / "pump.toml"
    bearings = f"{OIL}{OVER_SPEED.format('0.0', repr(text))}\n{FROZEN}whirl_frequency = '{text}'\n"
    file.write_text(f'name = "pump"\n{SHAFT}{bearings}[reduction]\nspeed = "{text}"\n')
    rotor = load_rotor(file)
    again = load_rotor(rotor, {"reduction": {"accuracy": 1e-4}})
    for read in (rotor, again):
        oil, gland = read.bearings
        speeds = [read.reduction.speed, oil.at_speed[1].speed, gland.whirl_frequency]
        assert speeds == pytest.approx([330.0 * math.pi] * 3, rel=1e-15)
        assert oil.at_speed[0].speed == 0.0
    assert ReductionOptions(speed=1.0).speed == 1.0
