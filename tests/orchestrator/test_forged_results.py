"""Results from elsewhere: they show no byte of another file, and take no more memory than their size explains."""

import json
import zlib

import h5py
import numpy as np
import pytest

from amb_cosim.comparison.compare import Side, side_by_side
from amb_cosim.cosim.record.signals import EACH_STEP, Samples, SignalTable
from amb_cosim.cosim.record.untrusted_netcdf import MOST_INFLATED
from amb_cosim.cosim.run.dataset import save
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.cosim.system.profile_file import profiles_of
from amb_cosim.results.result import Result
from tests.support.messages import assert_names, raises_naming

N = 100
PERIOD = 0.02  # s, of the synthetic scenario
SECRET = bytes(range(32, 132))


@pytest.fixture
def result(tmp_path):
    """The path of a result with a signal, without its checksum, as another program leaves it."""
    attributes = {"units": "m", "component": "one", "description": "", "causality": "output"}
    samples = Samples(np.sin(np.arange(N)), attributes)
    time = Samples(0.1 * np.arange(N), {"units": "s"})
    outcome = json.dumps(["completed", 1.0, None, ""])
    save(SignalTable({"one.x": samples}, {"time": time}, {"outcome": outcome}), file := tmp_path / "result.nc")
    file.write_bytes(file.read_bytes()[:-4])
    return file


def virtual_array(file, other):
    layout = h5py.VirtualLayout(shape=(N,), dtype="f8")
    layout[:] = h5py.VirtualSource(f"{other}.h5", "secret", shape=(N,))
    return file.create_virtual_dataset("spy.x", layout)


SPIES = {  # arrays and links in a result, to another file
    "external storage": lambda file, other: file.create_dataset(
        "spy.x", shape=(N,), dtype="u1", external=[(str(other), 0, N)]
    ),
    "virtual array": virtual_array,
    "external link": lambda file, other: file.update({"spy.x": h5py.ExternalLink(f"{other}.h5", "secret")}),
    "soft link": lambda file, other: file.update({"spy.x": h5py.SoftLink("/one.x")}),
    "link in a group": lambda file, other: file.create_group("some/where").update(
        {"spy.x": h5py.ExternalLink(f"{other}.h5", "secret")}
    ),
}


@pytest.mark.parametrize("kind", SPIES)
def test_a_result_that_reads_another_file_is_refused(result, tmp_path, kind):
    (tmp_path / "secret").write_bytes(SECRET)
    with h5py.File(tmp_path / "secret.h5", "w") as other:
        other["secret"] = np.frombuffer(SECRET, np.uint8).astype(np.float64)
    with h5py.File(result, "a") as file:
        array = SPIES[kind](file, tmp_path / "secret")
        if array is not None:
            array.dims[0].attach_scale(file["time"])
    with raises_naming(ValueError, str(result), "spy.x"):
        Result.load(result)


def compressed_twice(file):
    created = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    created.set_chunk((10**6,))
    created.set_deflate(9)
    created.set_deflate(9)
    space = h5py.h5s.create_simple((10**6,))
    array = h5py.h5d.create(file.id, b"big", h5py.h5t.NATIVE_DOUBLE, space, created)
    array.write_direct_chunk((0,), zlib.compress(zlib.compress(bytes(8 * 10**6), 9), 9))


BOMBS = {
    "unstored chunks": lambda file: file.create_dataset("big", shape=(10**9,), chunks=(10**6,), dtype="f8"),
    "compressed twice": compressed_twice,
    "one array under many names": lambda file: file.update({f"big.{k}": file["one.x"] for k in range(100)}),
    "texts": lambda file: file.create_dataset("big", data=["a" * 1000] * 10, dtype=h5py.string_dtype()),
    "texts of an attribute": lambda file: file.attrs.create("big", ["a" * 1000] * 10, dtype=h5py.string_dtype()),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_a_result_that_announces_more_than_it_holds_is_refused(result, kind):
    with h5py.File(result, "a") as file:
        BOMBS[kind](file)
    with raises_naming(ValueError, str(result)) as error:
        Result.load(result)
    assert "big" in str(error.value)


@pytest.mark.parametrize("values", [[], [0.0, 0.1]])
def test_a_result_of_many_arrays_without_a_fixed_length_is_refused(result, values):
    """The time to read it grows with the square of their number: 400 of them take a minute."""
    with h5py.File(result, "a") as file:
        for k in range(101):
            file.create_dataset(f"one.y{k}", data=np.array(values), maxshape=(None,), chunks=(2,))
    with raises_naming(ValueError, str(result), "100 other", "length"):
        Result.load(result)


def test_a_constant_signal_of_any_length_is_read(tmp_path):
    """Its compression is the strongest that a record can have, and does not reach the limit."""
    n = 2_000_000
    attributes = {"units": "m", "component": "one"}
    signals = {"one.x": Samples(np.zeros(n), attributes), "one.on": Samples(np.ones(n, np.int8), attributes)}
    table = SignalTable(signals, {"time": Samples(np.zeros(n), {})}, {"outcome": '["completed", 1.0, null, ""]'})
    save(table, file := tmp_path / "result.nc")
    assert Result.load(file).dataset["one.x"].size == n
    with h5py.File(file) as stored:
        assert stored["one.x"].id.get_storage_size() > 8 * n / MOST_INFLATED


def changed(file, name, value):
    with h5py.File(file, "a") as stored:
        stored.attrs.pop(name, None)
        if value is not None:
            stored.attrs[name] = value


@pytest.fixture
def of_scenario(synthetic, tmp_path):
    """The path of the result of a scenario, without its checksum."""
    save(synthetic(outcome=json.dumps(["completed", 1.0, None, ""])), file := tmp_path / "result.nc")
    file.write_bytes(file.read_bytes()[:-4])
    return file


DEEP = "[" * 50_000 + "]" * 50_000


@pytest.mark.parametrize("value", [None, 3, "3", DEEP, [1.0, 2.0], np.nan])
def test_a_result_with_an_attribute_of_another_type_is_refused(result, value):
    changed(result, "outcome", value)
    with raises_naming(ValueError, str(result), "outcome"):
        Result.load(result)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, None) for name in ("places", "period_s", "speed_rad_s", "completed", "wall_s")),
        *((name, "abc") for name in ("places", "period_s", "speed_profile", "warnings", "notices", "parameters")),
        *((name, DEEP) for name in ("places", "parameters", "warnings", "scenario_data", "plot_figures")),
        ("period_s", 0.0),
        ("communication_step_s", -1.0),
        ("plot_cycles", 3.0),
        ("warnings", '[{"component": "a"}]'),
        ("settling", "1"),
        ("settling_s", -0.5),
        ("wall_s", -1.0),
    ],
)
def test_a_result_of_a_scenario_has_the_attributes_that_figures_use(of_scenario, name, value):
    file = of_scenario
    Result.load(file)
    changed(file, name, value)
    with raises_naming(ValueError, str(file), name):
        Result.load(file)


def longer_than_time(file):
    attributes = dict(file["one.x"].attrs)
    del file["one.x"]
    array = file.create_dataset("one.x", data=np.zeros(N + 1))
    array.attrs.update({name: attributes[name] for name in ("units", "component")})
    array.dims[0].attach_scale(file["time"])


def replaced(name, values):
    """Write a variable of a file again with these values over time."""

    def change(file):
        attributes = {key: value for key, value in file[name].attrs.items() if key != "DIMENSION_LIST"}
        del file[name]
        array = file.create_dataset(name, data=values(file["time"][()]))
        array.attrs.update(attributes)
        array.dims[0].attach_scale(file["time"])

    return change


@pytest.mark.parametrize("n", [0, 1, N - 1, N + 1])
def test_a_signal_has_as_many_samples_as_its_times(result, n):
    """Readers fill a shorter one up with zeros."""
    with h5py.File(result, "a") as file:
        replaced("one.x", lambda _: np.ones(n))(file)
    with raises_naming(ValueError, str(result), "one.x", f"{n} values", str(N)):
        Result.load(result)


@pytest.mark.parametrize(
    "change",
    [
        lambda file: file.pop("cycle"),
        replaced("cycle", lambda time: time),
        replaced("cycle", lambda time: np.where(time == 0.0, np.nan, time / PERIOD)),
        replaced("cycle", lambda time: -time / PERIOD),
        lambda file: file.attrs.update({"period_s": 2.0 * PERIOD}),
    ],
)
def test_the_cycles_of_a_result_are_its_times_in_periods(of_scenario, change):
    with h5py.File(of_scenario, "a") as file:
        change(file)
    with raises_naming(ValueError, str(of_scenario), "cycles"):
        Result.load(of_scenario)


@pytest.mark.parametrize(
    ("name", "unit"),
    [("rotor_contact.rb1.f_n", "kN"), ("rotor_contact.rb2.impulse", "N"), ("rotor_contact.rb1.whirl_speed", "rpm")],
)
def test_signals_at_sites_have_the_units_of_a_summary(of_scenario, name, unit):
    with h5py.File(of_scenario, "a") as file:
        file[name].attrs["units"] = unit
    with raises_naming(ValueError, str(of_scenario), name, unit):
        Result.load(of_scenario)
    with h5py.File(of_scenario, "a") as file:
        del file[name].attrs["units"]  # which a table would export as [1]
    with raises_naming(ValueError, str(of_scenario), name):
        Result.load(of_scenario)


def test_times_of_a_result_without_a_unit_are_exported_in_seconds(result, tmp_path):
    with h5py.File(result, "a") as file:
        del file["time"].attrs["units"]
    table = Result.load(result).to_csv(tmp_path / "run.csv", "one.x")
    assert table.read_text(encoding="utf-8").startswith('"time [s]","one.x [m]"\n')
    (profile,) = profiles_of(str(table), 0.0)
    assert profile.points[1] == (0.1, np.sin(1.0))


@pytest.mark.parametrize("name", ["time", EACH_STEP])
def test_times_of_a_result_are_in_seconds(result, name):
    with h5py.File(result, "a") as file:
        if name != "time":
            file.create_dataset(name, data=np.arange(3.0)).make_scale(name)
        file[name].attrs["units"] = "ms"
    with raises_naming(ValueError, str(result), name, "ms"):
        Result.load(result)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("bearings", {"mb1": "rb1", "mb2": "none"}),
        ("second", {"rb2": "none"}),
        ("stators", {"none": "mb1"}),
        ("measured", {"none": ["x", "y"]}),
        ("magnetic", ["none"]),
        ("apart", ["none"]),
        ("faces", {"face": "none"}),
    ],
)
def test_places_of_a_result_name_its_own_sites_and_bearings(of_scenario, field, value):
    with h5py.File(of_scenario, "a") as file:
        file.attrs["places"] = json.dumps(json.loads(file.attrs["places"]) | {field: value})
    with raises_naming(ValueError, str(of_scenario), "places", "none"):
        Result.load(of_scenario)


def test_a_result_without_scenario_has_no_summary(result):
    with raises_naming(ValueError, "not of a scenario"):
        _ = Result.load(result).summary


SAID = "not finite"


@pytest.fixture(params=["rotor_contact.mb1.x", "rotor_contact.rb1.f_n", "rotor_contact.rb1.whirl_speed"])
def odd(request, synthetic):
    """`odd(value)`: a result in which a signal has only this value, and the name of the signal."""
    dataset = synthetic(outcome=json.dumps(["completed", 1.0, None, ""]))

    def changed(value):
        dataset[request.param].values[:] = value
        return Result(dataset, Outcome("completed", 1.0, None, "")), request.param

    return changed


@pytest.mark.parametrize("value", [np.nan, 1e308])
def test_signals_that_are_not_finite_are_left_out_and_named(odd, synthetic, value):
    """Neither a key value nor a comparison can be computed of them."""
    result, name = odd(value)
    json.loads(result.summary.to_json(), parse_constant=pytest.fail)
    assert any(name in notice and SAID in notice for notice in result.summary.notices)
    whole = Result(synthetic(), result.outcome)
    compared = side_by_side([Side("whole", "", {}, whole), Side("odd", "", {}, result)])
    assert_names(str(compared), name, SAID)
    json.dumps(compared.as_dict(), allow_nan=False)
    assert compared.figures()


@pytest.mark.parametrize("figure", ["orbits", "contact"])
def test_figures_skip_a_signal_that_is_not_finite_or_name_it(odd, figure, tmp_path, runner):
    result, name = odd(np.nan)
    save(result.dataset, tmp_path / "result.nc")
    answer = runner("plot", "result.nc", figure)
    assert_names(answer.stderr, "result.nc", name, SAID)
    assert answer.exit_code == (0 if (tmp_path / f"{figure}.png").is_file() else 2)


@pytest.mark.parametrize("value", [np.nan, 1e308])
def test_traces_have_gaps_where_values_are_not_finite(odd, value):
    result, name = odd(value)
    axes = result.plot(name).axes[0]
    axes.figure.canvas.draw()
    assert "no finite value" in [text.get_text() for text in axes.texts]
    assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()


FLAGS = np.array([0, 1, 2], np.int32)
UNLABELLED = {
    "no time": lambda file: file.move("time", "clock"),
    "descending time": lambda file: file["time"].write_direct(file["time"][()][::-1].copy()),
    "an original name that is no text": lambda file: file["one.x"].attrs.update({"original_name": np.arange(2)}),
    "a unit that is a number": lambda file: file["one.x"].attrs.update({"units": 3.0}),
    "longer than time": longer_than_time,
    "fewer names than values": lambda file: file["one.x"].attrs.update(
        {"flag_values": FLAGS, "flag_meanings": "off on"}
    ),
    "values without names": lambda file: file["one.x"].attrs.update({"flag_values": FLAGS}),
}


def reshaped(name, shape):
    def change(file):
        del file[name]
        file.create_dataset(name, data=np.zeros(shape)).make_scale(name)

    return change


UNREADABLE = {  # on which readers fail with words of their own
    "coordinates": lambda file: file["one.x"].attrs.update({"coordinates": 3.0}),
    "CLASS": lambda file: file["time"].attrs.update({"CLASS": 3.0}),
    "NAME": lambda file: file["time"].attrs.update({"NAME": np.nan}),
    "_FillValue": lambda file: file["one.x"].attrs.update({"_FillValue": "x"}),
    "scale_factor": lambda file: file["one.x"].attrs.update({"scale_factor": 1000.0}),
    "_nc3_strict": lambda file: file.attrs.update({"_nc3_strict": 1}),
    "time has the shape ()": reshaped("time", ()),
    "one.x has the shape (100, 2)": reshaped("one.x", (N, 2)),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_a_result_that_netcdf_cannot_express_is_refused_by_name(result, name, capsys):
    with h5py.File(result, "a") as file:
        UNREADABLE[name](file)
    with raises_naming(ValueError, str(result), name):
        Result.load(result)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("name", "value"), [("CLASS", "x"), ("_Netcdf4Coordinates", [7.0])])
def test_dimensions_without_a_meaning_are_refused_in_a_sentence(result, name, value):
    with h5py.File(result, "a") as file:
        file["time"].attrs[name] = value
    with raises_naming(ValueError, str(result), "not those of a NetCDF file"):
        Result.load(result)


@pytest.mark.parametrize("kind", UNLABELLED)
def test_a_result_without_labelled_variables_over_time_is_refused(result, kind):
    with h5py.File(result, "a") as file:
        UNLABELLED[kind](file)
    with raises_naming(ValueError, str(result)):
        Result.load(result)
