"""A page of the live rig in a browser, and the actions of a user."""

from dataclasses import dataclass
from typing import Any

FASTEST = "0.7"  # log10 of the pace, 5 times real time
PATIENCE = 60_000  # ms


@dataclass(frozen=True)
class Rig:
    """A page of the live rig; `problems` are the errors and warnings of its console."""

    page: Any
    problems: list[str]

    @property
    def time(self) -> float:
        """Simulated time on the page's clock (s)."""
        return float(self.page.inner_text("#clock").replace("−", "-").split()[0])

    @property
    def modes(self) -> list[str]:
        """Contact at each site, `0` to `2`."""
        return [row.get_attribute("data-mode") for row in self.page.query_selector_all(".contact")]

    def settled(self) -> None:
        """Wait until the rotor has settled, and pause."""
        self.page.wait_for_selector(".contact", timeout=PATIENCE)
        self.page.wait_for_function(
            "!['settling', ''].includes(document.querySelector('#achieved').textContent)", timeout=PATIENCE
        )

    def go(self, time: float) -> None:
        """Go to a time (s) on the time line, and wait for it."""
        self.page.evaluate(
            """(time) => {
                const seek = document.querySelector("#seek");
                seek.value = time;
                seek.dispatchEvent(new Event("input"));
                seek.dispatchEvent(new Event("change"));
            }""",
            time,
        )
        self.reach(time)

    def reach(self, time: float) -> None:
        """Wait until the run is paused at a time (s)."""
        self.page.wait_for_function(
            """(time) => document.querySelector("#achieved").textContent === "paused"
                && Math.abs(parseFloat(document.querySelector("#clock").textContent) - time) < 3e-4""",
            arg=time,
            timeout=PATIENCE,
        )
        self.page.wait_for_timeout(150)  # texts follow within a tenth of a second

    def set(self, variable: str, value: float) -> None:
        """Set any variable by its name (in its unit)."""
        self.page.evaluate("document.querySelector('#variable-name').closest('details').open = true")
        self.page.fill("#variable-name", variable)
        self.page.fill("#variable-value", str(value))
        self.page.click("#variable-set")
