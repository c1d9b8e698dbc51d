"""Systems of FMUs without connections to anything of this project."""


def system_text(
    components: dict[str, str], event: str = "", end: str = "10 ms", more: str = "", at: str = "5 ms"
) -> str:
    """Return a system file in TOML: FMUs by the names of components, steps of 1 ms, all recorded.

    `event` is what the table `set` of an event holds at time `at`; `more` are tables that come after the components.
    """
    parts = [f'[[component]]\nname = "{name}"\nfmu = "{fmu}"\n' for name, fmu in components.items()]
    parts.append(f"""{more}
[experiment]
communication_step = "1 ms"
stop_time = "{end}"
record.variables = ["*"]
""")
    if event:
        parts.append(f'[[experiment.event]]\ntime = "{at}"\nset = {{ {event} }}\n')
    return "".join(parts)
