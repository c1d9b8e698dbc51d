"""What is general names no rig, no scenario and no figure of a pack: packs alone do."""

import re
from pathlib import Path

from amb_files.packs import packs

ROOT = Path(__file__).parents[2]
ROOMS = (
    "libraries",
    "orchestrator",
    "applications",
    "examples",
    "docs/how-to",
)  # models cite the thesis as the source of their equations
KINDS = (".py", ".js", ".c", ".h", ".toml", ".j2", ".md")
NAMES = re.compile(
    r"(?<!/)\b(MB[12]|RB[12]|s[1-8]|fig\d\w*|bath\w*|nelson_\w+|[tT]hes[ie]s|D[1-4]|(Figs?\.?|Tables?) \d\.\d+)\b"
)

# Names of the rig's parts as they are in its rotor files and scenarios: messages, examples, patterns.
PARTS = re.compile(r"\b([mre]b[12?*]|d[1-4?*]\.(u|phi|f_[xy?]))(?!\w)")

# Pages that run scenarios of a pack as examples, and name their parts in commands and results. All others are general.
EXAMPLES = {
    *(
        "change_the_friction_law",
        "cluster",
        "compare",
        "linear_model",
        "live",
        "own_pack",
        "report",
        "resume",
        "robustness",
        "traps",
    ),
    *("swap_a_component", "sweep", "sweep_results", "wasm"),
    *(f"tools/{tool}" for tool in ("README", "dymola", "ecos", "fmpy", "fmusim", "libcosim", "omsimulator", "pyfmi")),
}

# What remains, by file and with the reason.
REASONS = {
    **{
        f"examples/controllers/{name}": "is of the compressor, whose bearings are called so too"
        for name in ("cross_feedback.toml", "lead_notches.toml", "lqg.py")
    },
    "examples/casing/levitated_in_casing.toml": "is of the compressor, whose bearings are called so too",
    "orchestrator/amb_cosim/model_constants/README.md": "cites the thesis as the source of equations",
    "libraries/signal_chain/variables.py": "cites the thesis as the source of start values",
    "libraries/rotor_analysis/reduction.py": "cites the thesis as the source of equations 3.8 to 3.13",
    "orchestrator/amb_cosim/model_constants/controller_data.py": "cites the thesis as the source of equation 5.10",
    "orchestrator/amb_cosim/model_constants/magnetic_bearing.py": "start values are those of the rig's bearings",
    "orchestrator/amb_cosim/systems/levitated.toml": "leaves out the bushes of the rig, which its scenarios rely on",
    "orchestrator/amb_cosim/systems/passive.toml": "leaves out the bushes of the rig, which its scenarios rely on",
}


def named(text: str) -> list[str]:
    return sorted({result[0] for pattern in (NAMES, PARTS) for result in pattern.finditer(text)})


def files() -> list[Path]:
    result = [file for room in ROOMS for file in (ROOT / room).rglob("*") if file.suffix in KINDS]
    result = [file for file in result if file not in {ROOT / f"docs/how-to/{page}.md" for page in EXAMPLES}]
    return [file for file in result if not {"node_modules", "vendor", "fmi_headers", "__pycache__"} & {*file.parts}]


def test_no_general_file_names_content_of_a_pack():
    words_in = {str(file.relative_to(ROOT)): named(file.read_text(encoding="utf-8")) for file in files()}
    assert len(words_in) > 300
    assert {name: words for name, words in words_in.items() if words and name not in REASONS} == {}
    assert [name for name in REASONS if not words_in[name]] == []


def test_no_general_file_names_a_scenario_or_rotor_of_a_pack():
    """Examples in texts may: `drop`, `compressor_levitated` and `turbo_expander` say what they are.

    `run_up` and `run_down` are keys of machine files, too.
    """
    names = {file.stem for folder in packs().values() for file in folder.glob("[rs]*/*.toml") if "_" in file.stem}
    names -= {"compressor_levitated", "turbo_expander", "run_up", "run_down"}
    words = re.compile(rf"\b({'|'.join(sorted(names))})\b")
    words_in = {str(file.relative_to(ROOT)): words.findall(file.read_text(encoding="utf-8")) for file in files()}
    assert {name: of for name, of in words_in.items() if of} == {}


def helps() -> dict[str, str]:
    """The help texts of all commands where no pack is installed, by the names of the commands."""
    import click

    from amb_cosim.commands.cli import main
    from amb_files import packs

    packs.packs = dict

    def collect(command: click.Command, path: str) -> dict[str, str]:
        texts = {path: command.get_help(click.Context(command, info_name=path))}
        for name in command.list_commands(click.Context(command)) if isinstance(command, click.Group) else ():
            texts |= collect(command.get_command(click.Context(command), name), f"{path} {name}")
        return texts

    return collect(main, "amb-cosim")


def test_no_general_help_text_names_content_of_a_pack(run_python):
    result = run_python(helps)
    assert {"amb-cosim run", "amb-cosim study campbell"} <= result.keys()
    assert {command: named(text) for command, text in result.items() if named(text)} == {}
