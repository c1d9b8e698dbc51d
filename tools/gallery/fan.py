"""Write the fan of docs/how-to/measured.md, and the stand-in for its measurement, into a folder.

python -m tools.gallery.fan FOLDER
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "measured.md"


def block(text: str, begin: str) -> str:
    """Return the text of the page's first code block with this beginning."""
    return begin + text.partition(f"\n{begin}")[2].partition("```")[0]


def main() -> None:
    """Write `fan.toml`, and run the page's code that writes `impact.csv`."""
    folder, text = Path(sys.argv[1]), PAGE.read_text(encoding="utf-8")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "fan.toml").write_text(block(text, "# fan.toml"), encoding="utf-8")
    subprocess.run([sys.executable, "-c", block(text, "from pathlib import Path")], cwd=folder, check=True)


if __name__ == "__main__":
    main()
