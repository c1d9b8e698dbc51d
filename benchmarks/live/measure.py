"""Real-time factors of scenarios, everything recorded: native FMUs, WebAssembly in node and in Chromium.

All compute the scenario at 4 kHz as fast as they can. In node and Chromium the time begins at cycle 0; both times of a
native run include settling.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from pathlib import Path
from shutil import which
from statistics import median
from threading import Thread
from typing import Any
from urllib.parse import unquote

from rich.table import Table

from amb_cosim.presentation.text_tables import labelled_table
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import execute
from amb_live.rig import rig
from benchmarks.timing import environment

HERE = Path(__file__).parent
SCENARIOS = {"fig4_9": None, "fig5_6": None, "drop": 0.5}  # until (s) in place of the end
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
TIMEOUT = 600.0  # s
TYPES = {".js": "text/javascript", ".html": "text/html", ".json": "application/json"}

Ends = Mapping[str, float | None]  # scenarios, and until when (s) in place of their ends


def measure(scenarios: Ends = SCENARIOS, rounds: int = 3) -> dict[str, Any]:
    """Return the median real-time factors of each scenario, by where it was computed; None where that is not installed.

    The first round, in which code is compiled, is reported separately.
    """
    with tempfile.TemporaryDirectory(prefix="live-", ignore_cleanup_errors=True) as temporary:
        folder = Path(temporary)
        for name in scenarios:
            _write(name, folder / name)
        request = {"scenarios": [{"name": name, "until": until} for name, until in scenarios.items()], "rounds": rounds}
        (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
        result = {"native": _native(scenarios, rounds), "node": _in_node(folder), "chromium": _in_chromium(folder)}
    factors = {
        name: {place: _summary(times[name]) if times else None for place, times in result.items()} for name in scenarios
    }
    return {"factors": factors, "environment": environment()}


def as_tables(data: Mapping[str, Any]) -> list[Table | str]:
    """Return what `measure` returns as a table."""
    title = "Simulated seconds per second, everything recorded (in brackets: the first run, which compiles code)"
    places = ("native", "node", "chromium")
    table = labelled_table(title, "scenario", *places)
    for name, factors in data["factors"].items():
        table.add_row(name, *(_factor_text(factors[place]) for place in places))
    return [table]


def _factor_text(factor: Mapping[str, float] | None) -> str:
    return "not installed" if factor is None else f"{factor['median']:.3g} ({factor['first']:.3g})"


def _summary(factors: list[float]) -> dict[str, float]:
    return {"first": factors[0], "median": median(factors[1:]), "least": min(factors[1:])}


def _write(name: str, folder: Path) -> None:
    folder.mkdir()
    live_rig = rig(load_scenario(name))
    (folder / "rig.json").write_text(json.dumps(live_rig.data), encoding="utf-8")
    for key, content in live_rig.parts.items():
        (folder / key).write_bytes(content)


def _native(scenarios: Ends, rounds: int) -> dict[str, list[float]]:
    result: dict[str, list[float]] = {}
    for name, until in scenarios.items():
        prepared = prepare_run(load_scenario(name).changed(settling="simulated"), until=until)
        simulated = (prepared.last - prepared.first) * prepared.step_size
        result[name] = []
        for _ in range(rounds + 1):
            begin = time.perf_counter()
            execute(prepared)
            result[name].append(simulated / (time.perf_counter() - begin))
    return result


def _in_node(folder: Path) -> dict[str, list[float]] | None:
    node = which("node")
    if node is None:
        return None
    command = [node, str(HERE / "node.mjs"), str(folder), str(_page())]
    process = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    if process.returncode != 0:
        raise ValueError(f"node ended with {process.returncode}: {process.stderr.strip()[-500:]}")
    result: dict[str, list[float]] = json.loads(process.stdout)
    return result


def _in_chromium(folder: Path) -> dict[str, list[float]] | None:
    """Serve page and rigs on this machine, and let a browser report to the server."""
    browser = next(filter(None, map(which, BROWSERS)), None)
    if browser is None:
        return None
    answer: Future[dict[str, Any]] = Future()
    handler = partial(_Handler, {"/": HERE, "/page/": _page(), "/rigs/": folder}, answer)
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    Thread(target=server.serve_forever, daemon=True).start()
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}"]
    url = f"http://127.0.0.1:{server.server_port}/browser.html"
    process = subprocess.Popen([browser, *options, url], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        reported = answer.result(TIMEOUT)
    finally:
        process.terminate()
        process.wait()
        server.shutdown()
    if "error" in reported:
        raise ValueError(f"{browser}: {reported['error']}")
    result: dict[str, list[float]] = reported["factors"]
    return result


def _page() -> Path:
    return Path(str(resources.files("amb_live").joinpath("page")))


class _Handler(BaseHTTPRequestHandler):
    """Serves files from folders, selected by the beginning of the path, and receives the report."""

    def __init__(self, folders: Mapping[str, Path], answer: Future[dict[str, Any]], *arguments: Any) -> None:
        self._folders, self._answer = folders, answer
        super().__init__(*arguments)

    def do_GET(self) -> None:
        file = next(self._files(), None)
        if file is None:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Type", TYPES.get(file.suffix, "application/octet-stream"))
        self.end_headers()
        self.wfile.write(file.read_bytes())

    def do_POST(self) -> None:
        content = self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(204)
        self.end_headers()
        self._answer.set_result(json.loads(content))

    def log_message(self, *_: Any) -> None:
        """Log nothing."""

    def _files(self) -> Iterator[Path]:
        path = unquote(self.path)
        for begin, folder in sorted(self._folders.items(), key=lambda item: -len(item[0])):
            file = folder / path.removeprefix(begin)
            if path.startswith(begin) and file.is_file():
                yield file
