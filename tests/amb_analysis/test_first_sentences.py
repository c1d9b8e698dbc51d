"""Studies begin with a sentence that has the answer, in the units of their tables."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis import studies
from amb_analysis.studies.contact_traps import Traps
from amb_analysis.studies.receptance_identification import Identification, IdentifiedReceptance
from amb_analysis.studies.run_spectra import BearingSpectra, Waterfall
from amb_analysis.studies.stability_margin import StabilityMargin
from amb_analysis.studies.trap_states import KINDS, Regime, SynchronousState
from amb_cosim.presentation.text_tables import rendered
from amb_cosim.presentation.units import speed_unit, units
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names

ANSWERED = {
    "campbell": {"rotor": "compressor"},
    "unbalance_response": {"rotor": "turbo_pump", "up_to": "6000 rpm"},
    "poles": {"scenario": "compressor_levitated", "up_to": "9000 rpm", "count": 40},
    "sensitivity": {"scenario": "compressor_levitated"},
}


def numbers(text):
    return [float(number) for number in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]\d+)?", text)]


def rpm(speed):
    return f"{30.0 / math.pi * speed:.0f} rpm"


def first_line(result):
    return str(result.text()[0])


def test_campbell_counts_critical_speeds_and_names_the_least_damped_and_the_nearest():
    result = studies.campbell("compressor", speed="9000 rpm")
    worst = min(result.critical_speeds, key=lambda row: row.damping_ratio)
    nearest = min(result.critical_speeds, key=lambda row: abs(row.speed - 300.0 * math.pi))
    count = f"{len(result.critical_speeds)} critical speeds"
    assert_names(first_line(result), count, rpm(worst.speed), f"{worst.damping_ratio:.3g}", rpm(nearest.speed), "9000")
    least, _, near = first_line(result).partition(";")
    assert worst.whirl in least
    assert nearest.whirl in near
    assert_names(first_line(studies.campbell("compressor", up_to="100 rpm")), "No critical speed", "100 rpm")


def test_unbalance_response_states_the_largest_amplitude_and_share_of_a_clearance():
    result = studies.unbalance_response("compressor", unbalance="1 g.m", place="impeller1")
    peaks = {name: float(place.amplitude.max()) for name, place in result.places.items()}
    name = max(peaks, key=peaks.get)
    shares = {n: 100.0 * peaks[n] / p.clearance for n, p in result.places.items() if p.clearance is not None}
    nearest = max(shares, key=shares.get)
    assert_names(
        first_line(result), f"{len(result.critical_speeds)} critical", name, nearest, f"{shares[nearest]:.3g} %"
    )


@pytest.mark.usefixtures("few_speeds")
def test_default_unbalance_of_a_rotor_is_that_of_its_balancing_grade():
    """G 2.5 is 2.5 mm/s of the centre of mass, here at the trip speed of the rotor's file."""
    rotor = load_rotor("turbo_pump")
    result = studies.unbalance_response(rotor, up_to="1000 rpm")
    assert result.unbalance == pytest.approx(2.5e-3 * rotor.mass / rotor.reduction.speed)


@pytest.mark.usefixtures("few_speeds")
def test_unbalance_response_says_that_a_rotor_beyond_its_clearance_touches():
    """Amplitudes are proportional to the unbalance."""
    small = studies.unbalance_response("turbo_pump", unbalance=1e-6, up_to="6000 rpm")
    share = max(float(p.amplitude.max()) / p.clearance for p in small.places.values() if p.clearance is not None)
    for factor in (0.5, 2.0):
        line = first_line(studies.unbalance_response("turbo_pump", unbalance=factor * 1e-6 / share, up_to="6000 rpm"))
        assert_names(line, f"{100.0 * factor:.3g} % of the clearance")
        assert ("touches" in line) == (factor > 1.0)


def test_sensitivity_begins_with_the_worst_axis_and_its_zone():
    def axis(peak, zone):
        return SimpleNamespace(
            **{"peak": peak, "peak_frequency": 40.0, "zone": zone, "beyond": None},
            **{"largest_difference_below_500_hz": 0.0, "largest_difference": 0.0},
        )

    axes = {"a.x": axis(2.0, "A"), "b.y": axis(3.5, "B")}
    margin = SimpleNamespace(
        rotor="r",
        speed=100.0 * math.pi,
        axes=axes,
        disk_margins={},
        casing=None,
        _all_frequencies="",
        warning_lines=list,
    )
    assert_names(str(StabilityMargin.text(margin)[0]), "Zone B", "3.500", "40.0 Hz", "b.y", "3000 rpm")


@pytest.mark.parametrize("name", ANSWERED)
def test_first_sentence_has_the_numbers_of_its_tables(name):
    result = getattr(studies, name)(**ANSWERED[name])
    for chosen in ("rpm", "rad/s"):
        with units(chosen):
            first, *rest = (numbers(rendered([part])) for part in result.text())
            tabled = [number for some in rest for number in some]
            highest = [] if name == "sensitivity" else [speed_unit().of(float(result.speeds[-1]))]
            count = [len(getattr(result, "critical_speeds", ()))]
        known = [*tabled, *(100.0 * number for number in tabled), *highest, *count]
        assert [n for n in first if not any(math.isclose(n, k, rel_tol=6e-3, abs_tol=1e-9) for k in known)] == []
        assert len(first) >= 3


@pytest.mark.usefixtures("few_speeds")
def test_traps_answers_for_its_speed_and_unbalance_before_its_tables():
    result = studies.traps("compressor_levitated", unbalance="30 g.m")
    answer = first_line(result)
    assert_names(answer, rpm(result.speed), "30 g m")
    assert re.search("free|contact", answer)


@pytest.mark.parametrize(("chosen", "facts"), [("rpm", ("6000 rpm", "1200 rpm")), ("Hz", ("100 Hz", "20 Hz"))])
def test_traps_states_the_least_unbalance_and_its_speed(chosen, facts):
    found = SimpleNamespace(
        **{"speeds": [200.0 * math.pi], "unbalances": [1.0], "touching": (0.015, 40.0 * math.pi), "trapping": None},
        **{"speed": 200.0 * math.pi, "grade_limit_at_speed": 0.01},
    )
    with units(chosen):
        assert_names(Traps._reach(found), "15 g m", *facts)


def test_modes_and_their_shapes_have_one_unit_of_speeds():
    result = studies.modes("compressor", speeds="0, 3000 rpm", count=1)
    text = rendered(result.text())
    assert "rad/s" not in text
    assert [line.split()[1] for line in text.splitlines() if line.split()[:1] in (["conical"], ["cylindrical"])] == [
        "0",
        "3000",
    ]


@pytest.fixture
def waterfall():
    none, line = np.zeros((1, 1)), np.zeros(1)
    spectra = BearingSpectra(none, line, line, np.array([10.0]), line, 1e-3, 20.0, 33.0, 1e-4, 30.0)
    return Waterfall(
        scenario="run",
        window=1.0,
        times=line,
        spin_frequencies=line,
        frequencies=line,
        changing_speed=True,
        bearings={"west": spectra},
    )


def test_spin_speeds_of_spectra_are_in_rpm_and_frequencies_in_hz(waterfall):
    """10, 20 and 30 turns per s are 600, 1200 and 1800 rpm; a vibration has 33 Hz."""
    header, row = (line for line in rendered(waterfall.text()).splitlines() if "(mm)" in line or line[:4] == "west")
    assert (header.count("(rpm)"), header.count("(Hz)")) == (3, 1)
    assert row.split() == ["west", "1", "1200", "600", "0.1", "33.00", "1800"]
    with units("Hz"):
        assert_names(rendered(waterfall.text()), "at speed (Hz)")


def test_speeds_of_an_identification_are_in_rpm():
    failed = IdentifiedReceptance(20.0 * math.pi, 1, 3, 1.0, None, None, reason="too short")
    text = rendered(Identification(warnings=(), speeds=(20.0 * math.pi,), results=(failed,), table=None).text())
    assert_names(text, "speed (rpm)", "600", "too short")


def test_outcomes_of_states_say_whether_the_rotor_is_in_contact():
    state = SimpleNamespace(contact=("rb1",), stable=True, settles=True)
    assert "in contact" in SynchronousState.beyond(state, 1.0)
    state.contact = ()
    assert "free" in SynchronousState.beyond(state, 1.0)
    assert "in contact" not in SynchronousState.beyond(state, 1.0)
    assert_names(KINDS[Regime.CONTACT], "stays in contact", "contact-free orbit")


@pytest.mark.parametrize(
    ("top_speed", "wrong", "cure"),
    [
        (None, 1, "speed in [reduction]"),
        (None, None, None),  # right at all speeds to which it is right at rest
        (1000.0, 1, "band in [reduction]"),
        (150.0, 1, None),  # right at all speeds of this rotor
    ],
)
def test_rotor_says_where_the_plant_is_wrong_for_unbalance_and_what_helps(top_speed, wrong, cure):
    compressor = studies.layout("compressor")
    spinning = np.full(4, 1e-4)
    if wrong is not None:
        spinning[wrong] = 0.26
    frequencies = np.array([100.0, 200.0, 400.0, 800.0])
    error = replace(compressor.receptance, frequencies=frequencies, spinning=spinning)
    whirl = None if top_speed is None else replace(compressor.whirl, speed=top_speed)
    lines = [line for line in replace(compressor, receptance=error, whirl=whirl).text() if isinstance(line, str)]
    advice = [line for line in lines if "[reduction]" in line]
    assert len(advice) == (cure is not None)
    if cure is not None:
        assert_names(advice[0], rpm(200.0), "26 %", cure)


def test_response_of_a_free_rotor_names_its_resonance_beside_the_end_of_the_range():
    """The rigid motion, 1/(m omega^2), is largest at the lowest frequency; the first bending mode is the peak."""
    rotor = load_rotor("bath_rig")
    full = assemble(rotor)
    bending = free_modes(full.M[::2, ::2], full.K[::2, ::2])[0][0] / (2.0 * math.pi)
    result = studies.response(rotor="bath_rig", inputs=["d2.f_x"], outputs=["mb1.x"])
    at_end = str(result.text()[1])
    assert float(str(result).split("m/N")[1].split()[0]) == pytest.approx(bending, rel=1e-3)
    assert_names(at_end, "mb1.x/d2.f_x", "at an end", "1 Hz")
