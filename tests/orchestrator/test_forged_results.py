"""Results from elsewhere: they show no byte of another file, and take no more memory than their size explains."""

import json
import zlib
from collections.abc import Callable
from pathlib import Path

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


@pytest.fixture
def of_scenario(synthetic, tmp_path):
    """The path of the result of a scenario, without its checksum."""
    save(synthetic(outcome=json.dumps(["completed", 1.0, None, ""])), file := tmp_path / "result.nc")
    file.write_bytes(file.read_bytes()[:-4])
    return file


def attribute(name: str, value: object, of: str = "/") -> Callable[[h5py.File], None]:
    """Replace an attribute of a file or of one of its variables; None removes it."""

    def change(file):
        file[of].attrs.pop(name, None)
        if value is not None:
            file[of].attrs[name] = value

    return change


def spying(create):
    """Write an array of numbers beside the result, and let `create(file, path)` refer to it."""

    def change(file):
        path = Path(file.filename).parent / "secret"
        path.write_bytes(SECRET)
        with h5py.File(f"{path}.h5", "w") as other:
            other["secret"] = np.frombuffer(SECRET, np.uint8).astype(np.float64)
        array = create(file, str(path))
        if array is not None:
            array.dims[0].attach_scale(file["time"])

    return change


def virtual_array(file, other):
    layout = h5py.VirtualLayout(shape=(N,), dtype="f8")
    layout[:] = h5py.VirtualSource(f"{other}.h5", "secret", shape=(N,))
    return file.create_virtual_dataset("spy.x", layout)


def external_array(file, other):
    return file.create_dataset("spy.x", shape=(N,), dtype="u1", external=[(other, 0, N)])


def linked(group, link):
    """Let `spy.x` be a link in a group of the file."""
    return lambda file, other: file.require_group(group).update({"spy.x": link(f"{other}.h5")})


def external(path):
    return h5py.ExternalLink(path, "secret")


def compressed_twice(file):
    created = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    created.set_chunk((10**6,))
    created.set_deflate(9)
    created.set_deflate(9)
    space = h5py.h5s.create_simple((10**6,))
    array = h5py.h5d.create(file.id, b"big", h5py.h5t.NATIVE_DOUBLE, space, created)
    array.write_direct_chunk((0,), zlib.compress(zlib.compress(bytes(8 * 10**6), 9), 9))


def many_arrays(values):
    """The time to read arrays without a fixed length grows with the square of their number: 400 take a minute."""

    def change(file):
        for k in range(101):
            file.create_dataset(f"one.y{k}", data=np.array(values), maxshape=(None,), chunks=(2,))

    return change


def replaced(name, values):
    """Write a variable of a file again with these values over time."""

    def change(file):
        attributes = {key: value for key, value in file[name].attrs.items() if key != "DIMENSION_LIST"}
        time = file["time"]
        del file[name]
        array = file.create_dataset(name, data=values(time[()]))
        array.attrs.update(attributes)
        array.dims[0].attach_scale(time)

    return change


def reshaped(name, shape):
    def change(file):
        del file[name]
        file.create_dataset(name, data=np.zeros(shape)).make_scale(name)

    return change


def each_step_in_ms(file):
    file.create_dataset(EACH_STEP, data=np.arange(3.0)).make_scale(EACH_STEP)
    file[EACH_STEP].attrs["units"] = "ms"


def places_naming_none(field, value):
    return lambda file: attribute("places", json.dumps(json.loads(file.attrs["places"]) | {field: value}))(file)


DEEP = "[" * 50_000 + "]" * 50_000
FLAGS = np.array([0, 1, 2], np.int32)
NOT_NETCDF = ("not those of a NetCDF file",)
REFUSED = {  # changes of a result, and facts that its refusal names beside its path
    # arrays and links to another file
    "external storage": (spying(external_array), ("spy.x",)),
    "virtual array": (spying(virtual_array), ("spy.x",)),
    "external link": (spying(linked("/", external)), ("spy.x",)),
    "soft link": (spying(linked("/", lambda _: h5py.SoftLink("/one.x"))), ("spy.x",)),
    "link in a group": (spying(linked("some/where", external)), ("spy.x",)),
    # more than the file holds
    "unstored": (lambda file: file.create_dataset("big", shape=(10**9,), chunks=(10**6,), dtype="f8"), ("big",)),
    "compressed twice": (compressed_twice, ("big",)),
    "many names of an array": (lambda file: file.update({f"big{k}": file["one.x"] for k in range(100)}), ()),
    "texts": (
        lambda file: file.create_dataset("big", data=["a" * 1000] * 10, dtype=h5py.string_dtype()),
        ("big", "numeric"),
    ),
    "texts of an attribute": (
        lambda file: file.attrs.create("big", ["a" * 1000] * 10, dtype=h5py.string_dtype()),
        ("big",),
    ),
    "many empty arrays": (many_arrays([]), ("100 other", "length")),
    "many arrays": (many_arrays([0.0, 0.1]), ("100 other", "length")),
    # attributes of another type
    **{
        f"outcome {str(v)[:9]}": (attribute("outcome", v), ("outcome",))
        for v in (None, 3, "3", DEEP, [1.0, 2.0], np.nan)
    },
    # readers fill shorter signals up with zeros
    **{
        f"{n} samples": (replaced("one.x", lambda _, n=n: np.ones(n)), ("one.x", f"{n} values", str(N)))
        for n in (0, 1, N - 1, N + 1)
    },
    "time in ms": (attribute("units", "ms", "time"), ("time", "ms")),
    "steps in ms": (each_step_in_ms, (EACH_STEP, "ms")),
    # what readers refuse in words of their own
    "coordinates": (attribute("coordinates", 3.0, "one.x"), ("coordinates",)),
    "CLASS": (attribute("CLASS", 3.0, "time"), ("CLASS",)),
    "NAME": (attribute("NAME", np.nan, "time"), ("NAME",)),
    "_FillValue": (attribute("_FillValue", "x", "one.x"), ("_FillValue",)),
    "scale_factor": (attribute("scale_factor", 1000.0, "one.x"), ("scale_factor",)),
    "_nc3_strict": (attribute("_nc3_strict", 1), ("_nc3_strict",)),
    "time of no dimension": (reshaped("time", ()), ("time has the shape ()",)),
    "signal of two dimensions": (reshaped("one.x", (N, 2)), ("one.x has the shape (100, 2)",)),
    "CLASS without a meaning": (attribute("CLASS", "x", "time"), NOT_NETCDF),
    "dimensions without a meaning": (attribute("_Netcdf4Coordinates", [7.0], "time"), NOT_NETCDF),
    # variables over time without labels
    "no time": (lambda file: file.move("time", "clock"), ()),
    "descending time": (lambda file: file["time"].write_direct(file["time"][()][::-1].copy()), ()),
    "an original name that is no text": (attribute("original_name", np.arange(2), "one.x"), ()),
    "a unit that is a number": (attribute("units", 3.0, "one.x"), ()),
    "values without names": (attribute("flag_values", FLAGS, "one.x"), ()),
    "fewer names than values": (
        lambda file: file["one.x"].attrs.update({"flag_values": FLAGS, "flag_meanings": "off on"}),
        (),
    ),
}


@pytest.mark.parametrize(("change", "facts"), REFUSED.values(), ids=REFUSED)
def test_a_forged_result_is_refused_with_its_fault(result, capsys, change, facts):
    with h5py.File(result, "a") as file:
        change(file)
    with raises_naming(ValueError, str(result), *facts):
        Result.load(result)
    assert capsys.readouterr().err == ""


FORCE, IMPULSE, WHIRL = (f"rotor_contact.{name}" for name in ("rb1.f_n", "rb2.impulse", "rb1.whirl_speed"))
REFUSED_OF_SCENARIO = [
    # attributes that figures use
    *((attribute(name, None), (name,)) for name in ("places", "period_s", "speed_rad_s", "completed", "wall_s")),
    *(
        (attribute(name, "abc"), (name,))
        for name in ("places", "period_s", "speed_profile", "warnings", "notices", "parameters")
    ),
    *(
        (attribute(name, DEEP), (name,))
        for name in ("places", "parameters", "warnings", "scenario_data", "plot_figures")
    ),
    (attribute("period_s", 0.0), ("period_s",)),
    (attribute("communication_step_s", -1.0), ("communication_step_s",)),
    (attribute("plot_cycles", 3.0), ("plot_cycles",)),
    (attribute("warnings", '[{"component": "a"}]'), ("warnings",)),
    (attribute("settling", "1"), ("settling",)),
    (attribute("settling_s", -0.5), ("settling_s",)),
    (attribute("wall_s", -1.0), ("wall_s",)),
    # cycles that are not times in periods
    (lambda file: file.pop("cycle"), ("cycles",)),
    (replaced("cycle", lambda time: time), ("cycles",)),
    (replaced("cycle", lambda time: np.where(time == 0.0, np.nan, time / PERIOD)), ("cycles",)),
    (replaced("cycle", lambda time: -time / PERIOD), ("cycles",)),
    (attribute("period_s", 2.0 * PERIOD), ("cycles",)),
    # units that are not those of a summary; a table would export none as [1]
    *(
        (attribute("units", unit, name), (name, unit) if unit else (name,))
        for name, wrong in ((FORCE, "kN"), (IMPULSE, "N"), (WHIRL, "rpm"))
        for unit in (wrong, None)
    ),
    # places that name no site or bearing of the result
    *(
        (places_naming_none(field, value), ("places", "none"))
        for field, value in (
            ("bearings", {"mb1": "rb1", "mb2": "none"}),
            ("second", {"rb2": "none"}),
            ("stators", {"none": "mb1"}),
            ("measured", {"none": ["x", "y"]}),
            ("magnetic", ["none"]),
            ("apart", ["none"]),
            ("faces", {"face": "none"}),
        )
    ),
]


@pytest.mark.parametrize(("change", "facts"), REFUSED_OF_SCENARIO)
def test_a_forged_result_of_a_scenario_is_refused_with_its_fault(of_scenario, change, facts):
    Result.load(of_scenario)
    with h5py.File(of_scenario, "a") as file:
        change(file)
    with raises_naming(ValueError, str(of_scenario), *facts):
        Result.load(of_scenario)


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


def test_times_of_a_result_without_a_unit_are_exported_in_seconds(result, tmp_path):
    with h5py.File(result, "a") as file:
        del file["time"].attrs["units"]
    table = Result.load(result).to_csv(tmp_path / "run.csv", "one.x")
    assert table.read_text(encoding="utf-8").startswith('"time [s]","one.x [m]"\n')
    (profile,) = profiles_of(str(table), 0.0)
    assert profile.points[1] == (0.1, np.sin(1.0))


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
