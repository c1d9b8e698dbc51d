"""Rigs as folders of files, written once, sessions in node, and Debian's Chromium; tests of what is not installed are
skipped.
"""

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from command_line import run_program
from live_answers import Answers
from live_browser import Rig

from amb_cosim.scenario.scenario import load_scenario
from amb_live.page import write_page
from amb_live.rig import rig

HERE = Path(__file__).parent
ON_PAGE = ("fig5_6_pid", "drop")  # scenarios


@pytest.fixture(scope="session")
def node() -> str:
    result = shutil.which("node")
    if result is None:
        pytest.skip("node, which runs the engine of the live rig outside of a browser, is not installed")
    return result


@pytest.fixture(scope="session")
def rig_folder(create_once: Callable[..., Path]) -> Callable[[str], Path]:
    """`rig_folder(scenario)`, a name or a file: folder with `rig.json` and the parts by their keys."""

    def make(name: str) -> Path:
        def fill(folder: Path) -> None:
            result = rig(load_scenario(name))
            (folder / "rig.json").write_text(json.dumps(result.data), encoding="utf-8")
            for key, content in result.parts.items():
                (folder / key).write_bytes(content)

        return create_once(f"rig-{Path(name).stem}", fill)

    return make


@pytest.fixture
def session(node: str, rig_folder: Callable[[str], Path]) -> Callable[..., Answers]:
    """`session(scenario, watched, *requests, userChanges=None)`: answers to `load` and to these requests."""

    def call(name: str, watched: Sequence[str], *requests: dict[str, Any], **load: Any) -> Answers:
        text = json.dumps([{"type": "load", "watched": list(watched), **load}, *requests])
        command = [node, str(HERE / "drive.mjs"), str(rig_folder(name))]
        return Answers(json.loads(run_program(*command, input=text).stdout))

    return call


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """The browser."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright, which drives a browser, is not installed")
    result = shutil.which("chromium")
    if result is None:
        pytest.skip("chromium, the browser of Debian, is not installed")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=result, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def page_file(create_once: Callable[..., Path]) -> Path:
    """The page of the live rig with two scenarios."""

    def fill(folder: Path) -> None:
        write_page([rig(load_scenario(name)) for name in ON_PAGE], folder / "rig.html", "docs")

    return create_once("live-page", fill) / "rig.html"


@pytest.fixture
def open_rig(chromium: Any, page_file: Path) -> Iterator[Callable[..., Rig]]:
    """`open_rig(address, **context)`: a page in a new window, which must end without an error."""
    opened: list[tuple[Any, Rig]] = []

    def make(address: str | None = None, **options: Any) -> Rig:
        settings = {"viewport": {"width": 1440, "height": 900}, "reduced_motion": "reduce", **options}
        context = chromium.new_context(**settings)
        page, problems = context.new_page(), []
        page.on(
            "console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None
        )
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on(
            "request", lambda r: None if r.url.split(":")[0] in ("file", "blob", "data") else problems.append(r.url)
        )
        page.goto(address or page_file.as_uri())
        result = Rig(page, problems)
        opened.append((context, result))
        result.settled()
        return result

    yield make
    for context, result in opened:
        context.close()
        assert result.problems == []
