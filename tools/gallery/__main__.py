"""Draw the pictures of the pages with the commands that the gallery names.

    python -m tools.gallery                     all pictures
    python -m tools.gallery landing campbell    some of them
    python -m tools.gallery --work FOLDER       keep the results there, and use those that are there

Each picture is a file that a command wrote, reduced in width and colours. A command whose results exist in the work
folder does not run again.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from tools.gallery.pictures import PICTURES, RUNS, Picture

DOCS = Path(__file__).parents[2] / "docs"
COLOURS = 256  # of a picture


def main() -> None:
    """Draw the named pictures, or all."""
    parser = argparse.ArgumentParser(description="Draw the pictures of the pages.")
    parser.add_argument("names", nargs="*", help="pictures; default: all")
    parser.add_argument("--work", type=Path, help="folder of the results; default: a temporary one")
    chosen = parser.parse_args()
    if unknown := [name for name in chosen.names if name not in PICTURES]:
        parser.error(f"{', '.join(unknown)}: not a picture; there are {', '.join(PICTURES)}")
    with tempfile.TemporaryDirectory() as temporary:
        work = chosen.work or Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        for name in chosen.names or PICTURES:
            draw(PICTURES[name], work)
            print(f"{name}: {(DOCS / PICTURES[name].file).stat().st_size / 1024:.0f} kB", flush=True)


def draw(picture: Picture, work: Path) -> None:
    """Run the commands of a picture that have not run yet, and write the picture."""
    for run in picture.needs:
        produce(RUNS[run], work, work / run)
    drawn = work / picture.drawn
    produce(picture.command, work, drawn)
    reduce(drawn, DOCS / picture.file, picture.width)


def produce(command: str, work: Path, result: Path) -> None:
    """Run a command in the work folder unless its result exists: of `amb-cosim`, or a module of this repository."""
    if not command or result.exists():
        return
    arguments = shlex.split(command)
    if arguments[0] == "-m":
        program, environment = [sys.executable], {**os.environ, "PYTHONPATH": str(DOCS.parent)}
    else:
        program, environment = [str(Path(sys.executable).with_name("amb-cosim"))], None
    subprocess.run([*program, *arguments], cwd=work, check=True, stdout=subprocess.DEVNULL, env=environment)


def reduce(drawn: Path, file: Path, width: int) -> None:
    """Write a picture with a width (pixels), at most as drawn, and few colours. A moving picture is copied."""
    if drawn.suffix == ".gif":
        shutil.copyfile(drawn, file)
        return
    with Image.open(drawn) as picture:
        size = (width, round(width * picture.height / picture.width))
        small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS) if picture.width > width else picture
        file.parent.mkdir(parents=True, exist_ok=True)
        small.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
            file, optimize=True
        )


if __name__ == "__main__":
    main()
