"""The command group for rotor files, and its command `import`."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import FREQUENCY, output
from amb_cosim.commands.packs import PackCommands
from amb_files.atomic import check_writable, write_file


@click.group(cls=PackCommands)
def rotor() -> None:
    """Import or show a rotor file."""


@rotor.command("import")
@click.argument("model", type=click.Path(path_type=Path))
@output("Rotor file; default: MODEL_rotor.toml.")
@click.option("--frequency", type=FREQUENCY, help="Whirl frequency at which coefficients are frozen, such as 100 Hz.")
def import_model(model: Path, output: Path | None, frequency: str | None) -> None:
    """Convert a rotor saved by ROSS to a rotor file.

    MODEL is the TOML file that ROSS saved. ROSS need not be installed. If MODEL has magnetic bearings under PID
    control, a controller file and a scenario in which these bearings levitate the rotor are also written. Other
    coefficients that depend on the whirl frequency require --frequency, because coefficients in rotor files depend only
    on the spin speed.
    """
    import tomli_w

    from amb_cosim.controllers.ross_magnets import levitation_files
    from amb_cosim.cosim.system.values import quantity
    from rotor_analysis.ross_file import read_ross

    path = output or Path(f"{model.stem}_rotor.toml")
    with refusing():
        check_writable(path, is_folder=False)
        omega = None if frequency is None else quantity(frequency, "rad/s", "--frequency")
        content, notes, magnets = read_ross(model, omega)
        magnet_files = levitation_files(model.stem, path.name, magnets) if magnets else {}
        for name in magnet_files:
            check_writable(path.with_name(name), is_folder=False)
        head = "".join(
            f"# {line}\n" for line in (f"Imported from {model.name}, a file saved by ROSS. SI units.", *notes)
        )
        texts = {path.name: head + "\n" + tomli_w.dumps(content)} | magnet_files
        for name, text in texts.items():
            write_file(path.with_name(name), text)
    for note in notes:
        click.echo(f"note: {note}", err=True)
    for name in texts:
        click.echo(path.with_name(name))


COMMANDS = (rotor,)
