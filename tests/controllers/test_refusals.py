"""Errors in a law, its signal names or its file: one message that names the fault."""

import ast
import sys
from importlib.util import find_spec
from pathlib import Path

import control
import numpy as np
import pytest
import scipy.signal
from scipy.io import savemat

from amb_cosim import linear_controller
from amb_cosim.controllers.array_file import read_arrays
from amb_files import array_files
from tests.support.messages import raises_naming

T = 1e-4
LAG = control.tf([1.0], [0.01, 1.0])
MATRICES = ([[-1.0]], [[1.0]], [[1.0]], [[0.0]])


def make(K=LAG, inputs=("y",), outputs=("u",), sample_time=T, **options):
    return linear_controller(K, inputs, outputs, sample_time, **options)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"K": "no such file.mat"}, "no controller file 'no such file.mat'"),
        ({"K": object()}, "a controller of type object is not allowed; it must be a StateSpace"),
        ({"K": control.frd([1.0, 2.0], [1.0, 2.0])}, "a controller of type FrequencyResponseData is not allowed"),
        ({"K": {}}, "a controller without speeds is not allowed"),
        ({"K": {"fast": LAG}}, "speed = 'fast' is not a number"),
        ({"K": {np.nan: LAG}}, "speed = nan is not allowed"),
        ({"K": {True: LAG}}, "speed = true is not a number"),
        ({"K": {1.0: LAG, 2.0: LAG * LAG}}, "1 states at 1 rad/s and 2 at 2 rad/s"),
        ({"K": {1.0: LAG, 2.0: control.append(LAG, LAG)}}, "1 states at 1 rad/s and 2 at 2 rad/s"),
        ({"K": {1.0: 1.0, 2.0: np.eye(2)}}, r"D of shape \(1, 1\) at 1 rad/s and \(2, 2\) at 2 rad/s is not allowed"),
        ({"K": {1.0: LAG, 2.0: ([1.0], [np.nan, 1.0])}}, "at 2 rad/s: .*not finite"),
        ({"K": ([[1.0, 2.0]], *MATRICES[1:])}, r"A of shape \(1, 2\) is not allowed"),
        ({"K": (*MATRICES[:1], [[1.0], [2.0]], *MATRICES[2:])}, r"B of shape \(2, 1\) is not allowed"),
        ({"K": (*MATRICES[:2], [[1.0, 2.0]], MATRICES[3])}, r"C of shape \(1, 2\) is not allowed"),
        ({"K": (*MATRICES[:3], [[np.inf]])}, "D contains numbers that are not finite"),
        ({"K": (*MATRICES[:3], [[1j]])}, "D is not allowed; it must be an array of real numbers"),
        ({"K": (*MATRICES[:3], [["a"]])}, "D is not allowed; it must be an array of real numbers"),
        ({"K": np.zeros((1, 1, 1))}, r"D of shape \(1, 1, 1\) is not allowed"),
        ({"K": ([1.0, 0.0, 0.0], [1.0, 1.0])}, "a numerator of degree 2 over a denominator of degree 1"),
        ({"K": ([1.0], [0.0])}, "denominator = 0 is not allowed"),
        ({"K": ([1.0, 2.0], [1.0], 1.0)}, "2 zeros with 1 poles is not allowed"),
        ({"K": ([], [np.inf], 1.0)}, "poles = .* is not allowed; they must be finite"),
        ({"K": ([], [-1.0 + 2.0j], 1.0)}, "zeros .* and poles .* are not allowed"),
        ({"K": control.tf([1.0], [1.0, -1.0])}, r"a controller with a pole of magnitude 1\.0001"),
        ({"K": control.tf([1.0], [1.0, 0.5], 2e-4)}, r"a law sampled at 0\.0002 s is not allowed with"),
        ({"sample_time": None}, "sample_time is missing"),
        ({"sample_time": 0.0}, "sample_time = 0 s is not allowed"),
        ({"sample_time": np.nan}, "sample_time = nan is not allowed"),
        ({"sample_time": "fast"}, "sample_time = 'fast' is not a number"),
        ({"method": "bilinear"}, "no discretisation 'bilinear'"),
        ({"prewarp": 4e4}, "prewarp = 40000 rad/s is not allowed; it must be > 0 and below half"),
        ({"prewarp": 100.0, "method": "zoh"}, "prewarp is not allowed with zoh"),
        (
            {"K": control.append(control.ss(LAG), LAG), "method": "matched"},
            "matched is not allowed for several signals",
        ),
        ({"inputs": ["a", "b"]}, "2 inputs is not allowed; the law has 1 measured signals"),
        ({"outputs": []}, "0 outputs is not allowed; the law has 1 demands"),
        ({"inputs": None}, "inputs is missing; it must name the measured signals"),
        ({"inputs": [1]}, r"inputs = \[1\] is not allowed; it must be names"),
        ({"inputs": ["mb1 x"]}, "'mb1 x' is not allowed as a name of measured signals"),
        ({"inputs": ["u"]}, "u is a measured signal and a demand"),
        ({"inputs": ["Omega"]}, "variables declared twice: Omega"),
        ({"K": np.eye(2), "inputs": ["y", "y"], "outputs": ["u", "v"]}, "y occurs twice among the measured signals"),
        ({"gains": [1.0, 2.0]}, r"gain of shape \(2,\) is not allowed"),
        ({"gains": np.nan}, r"u\.gain = nan"),
        ({"limits": (2.0, 1.0)}, "limits of u, 2 and 1 A, are not allowed"),
        ({"limits": (1.0, 2.0, 3.0)}, r"limits of shape \(3,\)"),
        ({"delay": 40.0}, "delay = 40 is not allowed; it must be >= 0 and <= 32"),
        ({"slow_time": 0.0}, "slow_time = 0 s is not allowed"),
    ],
)
def test_error_names_the_fault_in_a_law(arguments, sentence):
    with pytest.raises(ValueError, match=sentence) as error:
        make(**arguments)
    assert "\n" not in str(error.value)


def test_a_law_unstable_between_two_speeds_is_refused():
    """Two stable matrices whose mean is not: their poles are 0, those between them +-2.165 and more."""
    low = ([[0.0, 5.0], [0.0, 0.0]], [[1.0], [1.0]], [[1.0, 1.0]], [[0.0]])
    high = ([[0.0, 0.0], [5.0, 0.0]], *low[1:])
    with raises_naming(ValueError, "2.16506351", "125 rad/s"):
        make({100.0: low, 200.0: high}, sampled_arrays=True)
    make({100.0: low, 200.0: high}, sampled_arrays=True, allow_unstable=True)


@pytest.mark.parametrize(
    "K",
    [
        LAG,
        control.ss(LAG),
        control.zpk([], [-100.0], 100.0),
        scipy.signal.TransferFunction([1.0], [0.01, 1.0]),
        scipy.signal.StateSpace([[-100.0]], [[1.0]], [[100.0]], [[0.0]]),
        scipy.signal.ZerosPolesGain([], [-100.0], 100.0),
        ([[-100.0]], [[1.0]], [[100.0]], [[0.0]]),
        ([], [-100.0], 100.0),
        ([1.0], [0.01, 1.0]),
        {0.0: LAG},
        LAG.sample(T, "tustin"),
        control.ss(LAG.sample(T, "tustin")),
    ],
)
def test_a_law_has_the_same_response_in_every_form(K):
    z = np.exp(1j * np.array([1.0, 100.0, 3000.0]) * T)
    result = make(K).state_space()
    np.testing.assert_allclose(result(z), LAG.sample(T, "tustin")(z), rtol=1e-11)


def test_high_order_zeros_poles_and_gain_keep_their_digits():
    """Twelve notches from 50 to 600 Hz: as one polynomial the depth of the last would be lost."""
    omegas = 2.0 * np.pi * np.arange(50.0, 650.0, 50.0)
    zeros = np.concatenate([1j * omegas, -1j * omegas])
    poles = np.concatenate([omegas * (-0.1 + s * 1j * np.sqrt(0.99)) for s in (1, -1)])
    law = make((zeros, poles, 1.0)).state_space()
    exact = lambda s: np.prod((s - zeros) / (s - poles))  # noqa: E731
    for omega in (10.0, 333.0, 2500.0):
        warped = 2.0 / T * np.tan(omega * T / 2.0)
        assert law(np.exp(1j * omega * T)) == pytest.approx(exact(1j * warped), rel=1e-9)


def test_matrix_of_transfer_functions_needs_no_slycot():
    law = control.tf([[[1.0], [2.0]], [[3.0], [4.0, 5.0]]], [[[1.0, 1.0], [1.0, 2.0]], [[1.0, 3.0], [1.0, 4.0]]])
    result = make(law, ["a", "b"], ["u", "v"], method="zoh").state_space()
    np.testing.assert_allclose(result(1.0), law(0.0), rtol=1e-9)


def test_signals_are_named_by_the_labels_of_a_state_space():
    law = control.ss(LAG, inputs=["at_bearing"], outputs=["coil"])
    ports = linear_controller(law, sample_time=T).ports
    assert (ports.signals, ports.demands) == (("at_bearing",), ("coil",))


def content():
    return {
        "A": np.array([[0.5]]),
        "B": np.array([[1.0, 2.0]]),
        "C": np.array([[3.0]]),
        "D": np.array([[0.0, 1.0]]),
        "Ts": T,
        "inputs": np.array(["a", "b"]),
        "outputs": np.array(["u"]),
    }


def test_a_controller_is_read_from_arrays_of_a_mat_file(tmp_path):
    cells = {key: value.astype(object) if key in ("inputs", "outputs") else value for key, value in content().items()}
    savemat(tmp_path / "law.mat", cells)
    controller = linear_controller(tmp_path / "law.mat")
    assert controller.ports.signals == ("a", "b")
    assert controller.sample_time == T
    np.testing.assert_array_equal(controller.laws[0.0].B, [[1.0, 2.0]])


@pytest.mark.parametrize("suffix", ["mat", "npz"])
def test_saved_and_loaded_controller_is_the_same(tmp_path, suffix):
    table = {100.0: LAG, 50.0: 2.0 * LAG}
    made = make(table, gains=3.0, limits=(-1.0, 2.0), delay=1.5, slow_time=0.02)
    again = linear_controller(made.save(tmp_path / f"law.{suffix}"))
    for a, b in zip(made.model_and_constants, again.model_and_constants, strict=True):
        assert (a == b).all() if isinstance(a, np.ndarray) else a.interface == b.interface


def test_an_array_of_python_objects_is_refused_without_advice_to_unpickle(tmp_path):
    np.savez(tmp_path / "law.npz", A=np.array([{}], object), **dict(zip("BCD", MATRICES[1:], strict=True)))
    with raises_naming(ValueError, str(tmp_path / "law.npz"), "Python objects"):
        linear_controller(tmp_path / "law.npz")


@pytest.mark.parametrize("kind", ["M8[s]", "m8[s]", "bool", "S1", "U1", [("value", "f8")]])
@pytest.mark.parametrize("name", ["A", "D"])
def test_matrices_of_a_file_are_numbers(tmp_path, name, kind):
    """NumPy converts dates, truth values and records of one field to numbers without a word."""
    changed = {name: np.zeros(content()[name].shape, kind)}
    np.savez(tmp_path / "law.npz", **content() | changed)
    with raises_naming(ValueError, str(tmp_path / "law.npz"), name, "numbers"):
        linear_controller(tmp_path / "law.npz")


@pytest.mark.parametrize("suffix", ["mat", "npz"])
def test_a_small_file_with_huge_arrays_is_refused_before_they_are_read(tmp_path, suffix):
    path, matrices = tmp_path / f"law.{suffix}", {"A": np.zeros((6000, 6000)), "B": 0.0, "C": 0.0, "D": 0.0}
    if suffix == "mat":
        savemat(path, matrices, do_compression=True)
    else:
        np.savez_compressed(path, **matrices)
    assert path.stat().st_size < 1e6
    with pytest.raises(ValueError, match=rf"law\.{suffix}: .*\.{suffix} file: .* 288\d+ bytes.* 268435456 bytes$"):
        linear_controller(path)


def test_reading_a_mat_file_takes_no_more_memory_than_is_allowed(tmp_path, monkeypatch):
    path = tmp_path / "law.mat"
    savemat(path, {"A": np.zeros((5000, 5000)), "B": 0.0, "C": 0.0, "D": 0.0}, do_compression=True)
    assert path.stat().st_size < 1e6
    monkeypatch.setattr(array_files, "MAT_SPACE", 2**28)
    with pytest.raises(ValueError, match=r"law\.mat: .*(allocate|[Mm]emory)"):
        linear_controller(path)


def test_the_reason_for_a_damaged_file_is_short(tmp_path):
    """With a wrong name length in an archive, zipfile prints that much of the file as a name."""
    path = tmp_path / "law.npz"
    np.savez(path, A=np.zeros((40, 40)), B=0.0, C=0.0, D=0.0)
    content = bytearray(path.read_bytes())
    content[26:28] = (5000).to_bytes(2, "little")  # of the first entry's name
    path.write_bytes(content)
    with raises_naming(ValueError, str(path), ".npz") as caught:
        linear_controller(path)
    assert len(str(caught.value)) < 500


PACKAGES = ("amb_cosim", "amb_files", "fmi_export", "rotor_analysis")


def test_a_module_beside_a_mat_file_is_not_imported(tmp_path, monkeypatch):
    path = tmp_path / "law.mat"
    savemat(path, {name: np.eye(2) for name in "ABCD"} | {"Ts": 1e-4})
    for module in ("numpy", "scipy", "json"):
        (tmp_path / f"{module}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\nraise SystemExit('it ran')\n")
    monkeypatch.chdir(tmp_path)
    assert read_arrays(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("package", PACKAGES)
def test_child_processes_do_not_import_from_the_working_folder(package):
    """`sys.executable` is followed by -P wherever it begins a command."""
    (folder,) = find_spec(package).submodule_search_locations
    for file in Path(folder).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.List) and node.elts and ast.unparse(node.elts[0]) == "sys.executable":
                assert ast.unparse(node.elts[1]) == "'-P'", f"{file}:{node.lineno}"
    assert sys.version_info >= (3, 11), "-P is there"
