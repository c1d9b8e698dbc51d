"""Systems of FMUs without connections to anything of this project."""

from collections.abc import Mapping
from pathlib import Path


def system_text(
    components: Mapping[str, object],
    event: str = "",
    end: str = "10 ms",
    more: str = "",
    at: str = "5 ms",
    step: str = "1 ms",
    coupling: str = "",
) -> str:
    """Return a system file in TOML: FMUs by the names of components, equal steps, all recorded.

    `event` is what the table `set` of an event holds at time `at`; `more` are tables that come after the components.
    """
    parts = [f'coupling = "{coupling}"\n'] if coupling else []
    parts += [f'[[component]]\nname = "{name}"\nfmu = "{fmu}"\n' for name, fmu in components.items()]
    parts.append(f"""{more}
[experiment]
communication_step = "{step}"
stop_time = "{end}"
record.variables = ["*"]
""")
    if event:
        parts.append(f'[[experiment.event]]\ntime = "{at}"\nset = {{ {event} }}\n')
    return "".join(parts)


def write_system(folder: Path, components: Mapping[str, object], **options: str) -> Path:
    """Write `system.toml`, whose text has these options; return its path."""
    path = folder / "system.toml"
    path.write_text(system_text(components, **options), encoding="utf-8")
    return path
