"""The page as PDF, printed by a browser if a browser is available."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from amb_files.atomic import plain_file, write_atomically

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
LONGEST = 120.0  # s
PDF = "assessment.pdf"


def browser() -> str | None:
    """Return the path of a browser that can print, if any."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


def print_page(page: Path) -> Path | None:
    """Print a page to a PDF file next to it, and return the path of this file, or None if no browser can print it."""
    browser_path = browser()
    if browser_path is None:
        return None

    def print_to(path: Path) -> None:
        options = ("--headless", "--disable-gpu", "--no-pdf-header-footer", "--no-sandbox")
        command = [browser_path, *options, f"--print-to-pdf={path}", page.resolve().as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=LONGEST)
        if not path.is_file():
            raise OSError("the browser wrote no file")

    try:
        write_atomically(plain_file(page.parent, PDF), print_to)
    except (OSError, subprocess.SubprocessError):
        return None
    return page.with_name(PDF)
