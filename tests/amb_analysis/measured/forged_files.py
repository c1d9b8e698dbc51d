"""Forged and broken files of measured data, by a seed, with what must become of them.

A case is a file name, its bytes, options of `studies.response`, and an expectation: `refused`, `true` (the responses of
the fan are read right), or `either` (one of both; a response that differs from the true one is wrong data).
"""

from __future__ import annotations

import io
import random
import zipfile
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy.io

N = 60
F = np.linspace(10.0, 600.0, N)
H = 0.3 / (1.0 - (F / 150.0) ** 2 + 0.02j * F / 150.0)  # m/s2 over N
NAME = "wheel.x/wheel.f_x"
HEADS = ("frequency [Hz]", f"{NAME} real [(m/s2)/N]", f"{NAME} imag [(m/s2)/N]")
ENDS = {"inputs": ["wheel.f_x"], "outputs": ["wheel.x"], "input_units": ["N"], "output_units": ["m/s2"]}
PLACES = {"1.x": "wheel.x", "2.x": "wheel.f_x"}


class Case(NamedTuple):
    """A file, options of the study, and what must become of it."""

    title: str
    file: str
    content: bytes
    expected: str
    options: Mapping[str, Any] = MappingProxyType({})


def table(heads: tuple[str, ...] = HEADS, columns: Any = None, separator: str = ",", form: str = "{!r}") -> str:
    """The text of a table."""
    columns = (F, H.real, H.imag) if columns is None else columns
    rows = [separator.join(form.format(float(value)) for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([separator.join(heads), *rows]) + "\n"


def with_line(text: str, number: int, line: str) -> str:
    lines = text.splitlines()
    lines[number] = line
    return "\n".join(lines) + "\n"


def arrays(kind: str, **changes: Any) -> bytes:
    """A `.npz` or `.mat` file of the response; a change of None leaves an array out."""
    content = {"frequencies": F, "response": H[:, None, None], **ENDS} | changes
    content = {key: value for key, value in content.items() if value is not None}
    stream = io.BytesIO()
    if kind == "npz":
        np.savez(stream, **content)
    else:
        cells = {k: np.array(v, dtype=object) if isinstance(v, list) else v for k, v in content.items()}
        scipy.io.savemat(stream, cells)
    return stream.getvalue()


def universal(kind: int = 4, number: str | None = None, points: int = N, head: str = "", **fields: int) -> str:
    """A universal file of the response, set 58, of text."""
    f = {"order": 6, "node": 1, "direction": 1, "ordinate": 12, "denominator": 13, "abscissa": 18, "even": 1} | fields
    rows = [part for value in H for part in (value.real, value.imag)]
    texts = [f"{value:20.12E}" for value in rows]
    if number is not None:
        texts[7] = number.rjust(20)[:20]
    lines = ["".join(texts[k : k + 4]) for k in range(0, len(texts), 4)]
    step = F[1] - F[0]
    return "\n".join(
        [
            *("    -1", "    58" + head, "NONE", "NONE", "NONE", "NONE", "NONE"),
            f"{kind:5d}{0:10d}{0:5d}{0:10d}{' NONE':<11}{f['node']:10d}{f['direction']:4d}{' NONE':<11}{2:10d}{1:4d}",
            f"{f['order']:10d}{points:10d}{f['even']:10d}{F[0]:13.5E}{step:13.5E}{0.0:13.5E}",
            f"{f['abscissa']:10d}{0:5d}{0:5d}{0:5d} {'Frequency':<20} {'Hz':<20}",
            f"{f['ordinate']:10d}{0:5d}{0:5d}{0:5d} {'Response':<20} {'m/s2':<20}",
            f"{f['denominator']:10d}{0:5d}{0:5d}{0:5d} {'Force':<20} {'N':<20}",
            f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}",
            *lines,
            "    -1\n",
        ]
    )


def tables() -> Iterator[Case]:
    good = table()

    def case(title: str, text: str | bytes, expected: str, suffix: str = "csv", **options: Any) -> Case:
        return Case(title, f"t.{suffix}", text if isinstance(text, bytes) else text.encode(), expected, options)

    yield case("as written", good, "true")
    yield case("byte order mark", b"\xef\xbb\xbf" + good.encode(), "true")
    yield case("UTF-16", good.encode("utf-16"), "either")
    yield case("UTF-16 without mark", good.encode("utf-16-le"), "refused")
    yield case("EBCDIC", good.encode("cp500"), "refused")
    yield case("Windows ends of lines", good.replace("\n", "\r\n"), "true")
    yield case("old Macintosh ends of lines", good.replace("\n", "\r"), "either")
    yield case("semicolons", table(separator=";"), "true")
    yield case("tabs", table(separator="\t"), "true", "tsv")
    yield case("decimal commas", table(separator=";").replace(".", ",").replace("wheel,", "wheel."), "either")
    yield case("empty", b"", "refused")
    yield case("headings alone", HEADS[0] + "," + HEADS[1] + "," + HEADS[2] + "\n", "refused")
    yield case("a single line", "\n".join(good.splitlines()[:2]) + "\n", "refused")
    yield case("half of the last line", good[:-8], "either")
    yield case("half of a row", with_line(good, 9, "100.0,0.2"), "refused")
    yield case("a cell too many", with_line(good, 9, "100.0,0.2,0.3,0.4"), "refused")
    yield case("a quote that is not closed", with_line(good, 9, '"100.0,0.2,0.3'), "refused")
    yield case("zeros of a torn disk", good.encode()[:900] + b"\0" * 600, "refused")
    for text in ("nan", "inf", "-inf", "1e400", "", "0x1F", "1_0", "--1", "1.2.3", "1e", "N/A", "#REF!", "1,000", "٣"):
        for column in range(3):
            cells = [repr(float(F[8])), repr(float(H[8].real)), repr(float(H[8].imag))]
            cells[column] = text
            yield case(f"{text!r} in column {column}", with_line(good, 9, ",".join(cells)), "refused")
    yield case("frequencies descend", table(columns=(F[::-1], H.real[::-1], H.imag[::-1])), "either")
    yield case("a frequency twice", table(columns=(np.repeat(F, 2)[:N], H.real, H.imag)), "refused")
    yield case("a negative frequency", table(columns=(-F[::-1], H.real, H.imag)), "refused")
    yield case("an infinite number in words", with_line(good, 9, f"{F[8]},Infinity,0"), "refused")
    yield case("two columns of one name", table((HEADS[0], HEADS[1], HEADS[1])), "refused")
    yield case("no real part", table((HEADS[0], HEADS[2]), (F, H.imag)), "refused")
    for unit in (
        "",
        "kg",
        "m",
        "m/kg",
        "N/m/s",
        "m/s2",
        "(m/s2)/(N",
        "()/N",
        "m/N)(",
        "[m]/[N]",
        "1e999 m/N",
        "%",
        "m/0 N",
    ):
        heads = (HEADS[0], f"{NAME} real [{unit}]", f"{NAME} imag [{unit}]")
        yield case(f"unit {unit!r}", table(heads), "refused")
    for unit in ("", "s", "m", "Hz/Hz", "°", "furlong", "Hz " * 3000):
        yield case(f"frequency in {unit[:20]!r}", table((f"frequency [{unit}]", *HEADS[1:])), "refused")
    contradicting = table((HEADS[0], HEADS[1], f"{NAME} imag [m/N]"))
    yield case("parts of two units", contradicting, "refused")
    yield case("no place of the rotor", good.replace("wheel.x/", "fan.x/"), "refused")
    yield case("a heading of a megabyte", good.replace("wheel.x", "w" * 10**6), "refused")
    yield case("a row of a megabyte", with_line(good, 9, "1," * 500_000), "refused")
    yield case("ten thousand columns", ",".join(f"c{k} [m]" for k in range(10_000)) + "\n" + "1," * 10_000, "refused")
    yield case("coherence of 7", table((*HEADS, f"{NAME} coherence"), (F, H.real, H.imag, 7 + 0 * F)), "refused")
    yield case("unknown stated unit", good, "refused", channel_units={"nothing": "m"})
    yield case("a channel without a name", good, "refused", channels={"": "wheel.x"})


def polar_tables() -> Iterator[Case]:
    """Amplitudes and phases whose units are not those of their headings."""
    heads = (HEADS[0], f"{NAME} amplitude [(m/s2)/N]", f"{NAME} phase [deg]")
    radians = (*heads[:2], f"{NAME} phase [rad]")
    size, phase = np.abs(H), np.angle(H)

    def case(title: str, heads: tuple[str, ...], size: Any, phase: Any, expected: str) -> Case:
        return Case(title, "t.csv", table(heads, (F, size, phase)).encode(), expected)

    yield case("amplitude and phase", heads, size, np.degrees(phase), "true")
    yield case("unwrapped phase in rad", radians, size, np.unwrap(phase) - 40.0 * np.pi, "true")
    yield case("decibels that are called (m/s2)/N", heads, 20.0 * np.log10(size), np.degrees(phase), "refused")
    yield case("a negative amplitude", heads, np.where(np.arange(N) == 7, -size, size), np.degrees(phase), "refused")
    yield case("columns of amplitude and phase exchanged", heads, np.degrees(phase), size, "refused")
    yield case("degrees that are called radians", radians, size, np.degrees(phase), "refused")
    yield case("a phase of 1e300 deg", heads, size, 1e300 + 0.0 * phase, "refused")
    for factor in (1e300, 1e-305):
        yield case(f"amplitudes times {factor:g}", heads, factor * size, np.degrees(phase), "refused")
    decibels = (HEADS[0], f"{NAME} amplitude [dB re 1 (m/s2)/N]", heads[2])
    yield case("1e5 dB", decibels, 1e5 + 0.0 * size, np.degrees(phase), "refused")


def files_of_arrays() -> Iterator[Case]:
    def case(title: str, kind: str, content: bytes, expected: str) -> Case:
        return Case(f"{title} in {kind}", f"a.{kind}", content, expected)

    for kind in ("npz", "mat"):
        good = arrays(kind)
        yield case("as written", kind, good, "true")
        for count in (0, 10, 100, len(good) // 2, len(good) - 30):
            yield case(f"the first {count} bytes", kind, good[:count], "refused" if count < 11 else "either")
        changes: dict[str, dict[str, Any]] = {
            "no frequencies": {"frequencies": None},
            "no units": {"output_units": None},
            "text in place of numbers": {"frequencies": ["a"] * N},
            "complex frequencies": {"frequencies": F + 1j},
            "infinite response": {"response": np.full((N, 1, 1), np.inf + 0j)},
            "response that is not a number": {"response": np.full((N, 1, 1), np.nan + 0j)},
            "response of another length": {"response": H[:-1, None, None]},
            "response of two outputs": {"response": np.ones((N, 2, 1), complex)},
            "no lines": {"frequencies": np.zeros(0), "response": np.zeros((0, 1, 1))},
            "five dimensions": {"response": np.ones((N, 1, 1, 2, 2), complex)},
            "numbers in place of names": {"outputs": np.arange(1.0)},
            "unit without a meaning": {"output_units": ["wheel"]},
            "two names": {"outputs": ["a.x", "b.x"]},
            "a response of zeros": {"response": np.zeros((N, 1, 1))},
            "truth values": {"response": np.ones((N, 1, 1), bool)},
            "numbers of 8 bits": {
                "frequencies": np.arange(1, N + 1).astype(np.int8),
                "response": np.ones((N, 1, 1), np.int8),
            },
            "time beside response": {"time": np.arange(8.0)},
        }
        for title, change in changes.items():
            beside = title in ("time beside response",)
            whole = title == "numbers of 8 bits"
            is_number = title == "truth values" and kind == "mat"  # which Matlab's format has as numbers
            expected = "true" if beside else "anything" if whole or is_number else "refused"
            yield case(title, kind, arrays(kind, **change), expected)
    pickled = io.BytesIO()
    np.savez(pickled, frequencies=np.array([{"a": 1}], dtype=object), response=H)
    yield case("an object of Python", "npz", pickled.getvalue(), "refused")
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("response.npy", "w") as stream:
        np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
        for _ in range(64):
            stream.write(b"\0" * 2**20)
    yield case("a billion numbers in 64 kB", "npz", bomb.getvalue(), "refused")
    yield case("a zip of something else", "npz", _zip({"a.txt": b"x"}), "refused")
    yield case("a zip in a zip", "npz", _zip({"response.npy": _zip({"response.npy": b"x"})}), "refused")
    nested: Any = 1.0
    for _ in range(30):
        nested = {"s": nested}
    yield case("thirty structures in each other", "mat", arrays("mat", response=nested), "refused")
    yield case("a table", "mat", table().encode(), "refused")
    yield case("a table", "npz", table().encode(), "refused")


def _zip(files: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()


def universal_files() -> Iterator[Case]:
    def case(title: str, text: str | bytes, expected: str) -> Case:
        content = text if isinstance(text, bytes) else text.encode()
        return Case(title, "u.uff", content, expected, {"channels": PLACES})

    good = universal()
    yield case("as written", good, "true")
    yield case("twice", good + good, "true")
    yield case("Windows ends of lines", good.replace("\n", "\r\n"), "true")
    yield case("padded lines", "\n".join(line.ljust(80) for line in good.splitlines()) + "\n", "true")
    yield case("empty", "", "refused")
    yield case("no end", good.rpartition("    -1")[0], "refused")
    yield case("no begin", good[7:], "refused")
    for points in (0, 1, N - 1, N + 1, 10**9, -5):
        yield case(f"{points} points announced", universal(points=points), "refused")
    for number in ("nan", "inf", "1.0E+999", "abc", "", "1.0D+00", "1,5", "******************"):
        yield case(f"{number!r} as a number", universal(number=number), "refused")
    for order in (0, 2, 4, 5, 7, 99):
        yield case(f"type of numbers {order}", universal(order=order), "refused")
    for direction in (4, 5, 6, 7, 99, -9):
        yield case(f"direction {direction}", universal(direction=direction), "refused")
    for key, value in (("ordinate", 8), ("ordinate", 99), ("denominator", 12), ("abscissa", 1), ("abscissa", 77)):
        by_label = (key, value) in (("ordinate", 99), ("abscissa", 1))
        yield case(f"type of data {value} of the {key}", universal(**{key: value}), "true" if by_label else "refused")
    for kind in (0, 2, 3, 5, 9, 27):
        yield case(f"type of function {kind}", universal(kind), "refused")
    yield case("uneven, but written as even", universal(even=0), "refused")
    yield case("text with a binary head", universal(head="b     1     2          11        10"), "refused")
    yield case(
        "binary head of a huge number of bytes", universal(head="b     1     2          11999999999999"), "refused"
    )
    yield case(
        "binary head of a huge number of lines", universal(head="b     1     2999999999999         960"), "refused"
    )
    yield case("a line of a megabyte", good.replace("NONE", "N" * 10**6, 1), "either")
    yield case("a hundred thousand ends", "    -1\n" * 100_000, "refused")
    yield case("zeros", b"\0" * 5000, "refused")
    yield case("a table", table(), "refused")


def damaged(chance: random.Random, count: int) -> Iterator[Case]:
    """Good files with a few other bytes, a part twice or a part less: read in any way, or refused."""
    goods: list[tuple[str, bytes]] = [
        ("t.csv", table().encode()),
        ("a.npz", arrays("npz")),
        ("a.mat", arrays("mat")),
        ("u.uff", universal().encode()),
    ]
    edits: list[Callable[[bytearray], bytearray]] = [
        lambda b: b[: chance.randrange(len(b))],
        lambda b: b[: (k := chance.randrange(len(b)))] + b[chance.randrange(k, len(b)) :],
        lambda b: b[: (k := chance.randrange(len(b)))] + b[: chance.randrange(len(b))] + b[k:],
        lambda b: bytearray(chance.randrange(256) if chance.random() < 0.002 else byte for byte in b),
    ]
    for k in range(count):
        file, content = goods[k % len(goods)]
        yield Case(f"damaged {k}", file, bytes(chance.choice(edits)(bytearray(content))), "anything")


def cases(seed: int, count: int) -> list[Case]:
    """All cases, and some damaged files."""
    return [*tables(), *polar_tables(), *files_of_arrays(), *universal_files(), *damaged(random.Random(seed), count)]
