#!/usr/bin/env python3
"""Makes what a release consists of from the last commit, the same bytes each time: `.ci/release.py [FOLDER] [--twice]`.

    amb_cosim-VERSION-py3-none-any.whl   with machine code for every platform and for browsers
    amb_cosim-VERSION.tar.gz             the sources
    fmus/                                FMUs of the README's scenario: fmi2, fmi3, python, and one of all in assembled
    NAME.ssp                             that scenario as a system for other tools, whose masters are parallel
    site.zip                             the documentation, to be unpacked and opened without a server
    sbom.json                            what the wheel was installed with (CycloneDX)
    notes.md                             the changelog of the version
    SHA256SUMS                           of all of these

It needs git, Python and a package index; versions are those of constraints.txt. The wheel is tried in an environment of
its own, where it must install and run without compiling; how long that takes is told. `--twice` makes everything
a second time, elsewhere and with nothing kept, and fails if a byte differs.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
NO_TIME = (1980, 1, 1, 0, 0, 0)


def main() -> None:
    """Make the release, once or twice."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "dist" / "release", help="where it goes")
    parser.add_argument("--twice", action="store_true", help="make it again, and compare")
    given = parser.parse_args()
    if subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, check=True).stdout:
        raise SystemExit("the work tree has changes; a release is made of a commit")
    target = given.folder.resolve()
    if target.exists() and any(target.iterdir()):
        raise SystemExit(f"{target} is not empty")
    make(target)
    if given.twice:
        with tempfile.TemporaryDirectory(prefix="release-again-") as again:
            make(Path(again))
            if differing := differences(target, Path(again)):
                raise SystemExit(f"made twice, these differ: {', '.join(differing)}")
        print("made twice, to the same bytes")
    print(target)


def make(target: Path) -> None:
    """Make a release of the last commit into a folder."""
    with tempfile.TemporaryDirectory(prefix="release-") as work:
        source, tools, clean = (Path(work, name) for name in ("source", "tools", "clean"))
        run("git", "clone", "-q", ROOT, source)
        for kept in ("NUMBA_CACHE_DIR", "PYTHONPATH", "ZIG_GLOBAL_CACHE_DIR"):  # of who makes the release
            os.environ.pop(kept, None)
        epoch = run("git", "log", "-1", "--format=%ct", cwd=source).strip()
        os.environ.update(
            AMB_COSIM_PLATFORMS="all",
            PIP_CONSTRAINT=str(source / "constraints.txt"),
            PYTHONHASHSEED="0",
            SOURCE_DATE_EPOCH=epoch,
            XDG_CACHE_HOME=str(Path(work, "cache")),
        )
        target.mkdir(parents=True, exist_ok=True)

        say("tools")
        run(sys.executable, "-m", "venv", tools)
        pip = [tools / "bin" / "python", "-m", "pip"]
        run(*pip, "install", "-q", "-e", ".[release]", cwd=source)
        python = tools / "bin" / "python"
        version = run(python, "-m", "hatchling", "version", cwd=source).strip()
        check_version(source, version)

        say(f"wheel and source archive of {version}")
        run(python, "-m", "hatchling", "build", "-d", target, cwd=source)

        say("an environment with the wheel alone")
        scenario = scenario_of((source / "README.md").read_text(encoding="utf-8"))
        used, began = processor_time(), time.monotonic()
        run(sys.executable, "-m", "venv", "--without-pip", clean)
        into = [*pip, "--python", clean / "bin" / "python"]
        run(*into, "install", "-q", "--find-links", target, f"amb-cosim=={version}")
        installed = processor_time() - used
        command = clean / "bin" / "amb-cosim"
        kept = Path(work, "kept")
        os.environ["XDG_CACHE_HOME"] = str(kept)
        run(command, "run", scenario, cwd=work)
        used = processor_time() - used
        print(f"   installed in {installed:.1f} s, with the first run {used:.1f} s of processor time, {since(began)}")
        if compiled := sorted(path.name for path in kept.glob("amb-cosim/*") if is_compiled(path)):
            raise SystemExit(f"the wheel compiled at its first run: {', '.join(compiled)}")

        say("FMUs, and the scenario as a system")
        every = ["--platform", "all"]
        for kind, options in {
            "fmi2": ["--scenario", scenario, *every],
            "fmi3": ["--scenario", scenario, *every, "--fmi", "3"],
            "python": ["--scenario", scenario, "--platform", "linux64,win64", "--flavour", "python"],
            "assembled": ["--assembled", scenario, *every],
        }.items():
            run(command, "build", *options, "-o", target / "fmus" / kind)
        for fmu in sorted((target / "fmus" / "python").glob("*.fmu")):
            leave_out(fmu, "resources/python.txt")  # names folders of this machine, which are others each time
        parallel = in_parallel_order(scenario, work)
        run(command, "export-ssp", parallel, "--integers", *every, "-o", target / f"{scenario}.ssp")

        say("site")
        os.environ["XDG_CACHE_HOME"] = str(Path(work, "cache"))
        build_site(tools, source, Path(work, "site"))
        archive(Path(work, "site"), target / "site.zip")

        say("SBOM, notes, checksums")
        run(
            tools / "bin" / "cyclonedx-py", "environment", "--output-reproducible", "-o", target / "sbom.json",
            clean / "bin" / "python",
        )  # fmt: skip
        text = (source / "CHANGELOG.md").read_text(encoding="utf-8")
        (target / "notes.md").write_text(notes(text, version), encoding="utf-8")
        (target / "SHA256SUMS").write_text(checksums(target), encoding="utf-8")


def build_site(tools: Path, source: Path, target: Path) -> None:
    """Build the site after the report, whose table of statements it shows."""
    run(tools / "bin" / "amb-cosim", "report", cwd=source)
    run(tools / "bin" / "python", "-m", "mkdocs", "build", "--strict", "--quiet", "-d", target, cwd=source)


def check_version(source: Path, version: str) -> None:
    """End the release of a tag if a file still names another version; commits after a tag have "dev" in theirs."""
    if "dev" in version:
        return
    named = {
        "pyproject.toml": f'fallback-version = "{version}"',
        "CITATION.cff": f"version: {version}",
        "CHANGELOG.md": f"## {version}",
    }
    for name, text in named.items():
        if not re.search(rf"^{re.escape(text)}(?!\S)", (source / name).read_text(encoding="utf-8"), re.MULTILINE):
            raise SystemExit(f"the tag is of version {version}, but no line of {name} begins with {text}")


def notes(changelog: str, version: str) -> str:
    """Return the section of a version or, without one, what is not released yet; links to files are left out."""
    sections = dict(re.findall(r"^## \[?([^\s\]]+)[^\n]*\n(.*?)(?=^## |\Z)", changelog, re.MULTILINE | re.DOTALL))
    section = re.sub(r"\[([^\]]*)\]\((?!\w+:|#)[^)]*\)", r"\1", sections.get(version, sections["Unreleased"]))
    return f"# amb-cosim {version}\n\n{section.strip()}\n"


def scenario_of(readme: str) -> str:
    """Return the scenario that the README's first command runs."""
    found = re.search(r"amb-cosim run (\w+)", readme)
    if not found:
        raise SystemExit("the README runs no scenario")
    return found[1]


def in_parallel_order(scenario: str, folder: str | Path) -> Path:
    """Write a scenario that steps all components at once, as most other masters do; return its file."""
    path = Path(folder, f"{scenario}.toml")
    path.write_text(f'base = "{scenario}"\ncoupling = "jacobi"\n', encoding="utf-8")
    return path


def archive(folder: Path, target: Path) -> None:
    """Write what is in a folder to a zip file, the same bytes for the same content."""
    with zipfile.ZipFile(target, "w") as whole:
        for path in files(folder):
            entry = zipfile.ZipInfo(path.relative_to(folder).as_posix(), NO_TIME)
            entry.compress_type, entry.create_system, entry.external_attr = zipfile.ZIP_DEFLATED, 3, 0o100644 << 16
            whole.writestr(entry, path.read_bytes(), compresslevel=6)


def leave_out(fmu: Path, name: str) -> None:
    """Take a file out of an FMU; the others keep their order and their bytes."""
    with zipfile.ZipFile(fmu) as made:
        kept = [(entry, made.read(entry)) for entry in made.infolist() if entry.filename != name]
    with zipfile.ZipFile(fmu, "w") as written:
        for entry, content in kept:
            written.writestr(entry, content)


def checksums(folder: Path) -> str:
    """Return what `sha256sum --check` reads of the files in a folder."""
    listed = [path for path in files(folder) if path.name != "SHA256SUMS"]
    return "".join(f"{digest(path)}  {path.relative_to(folder).as_posix()}\n" for path in listed)


def differences(one: Path, other: Path) -> list[str]:
    """Return the files that only one of two folders has, or that differ."""
    first, second = ({p.relative_to(folder).as_posix(): digest(p) for p in files(folder)} for folder in (one, other))
    return sorted(name for name in first.keys() | second.keys() if first.get(name) != second.get(name))


def files(folder: Path) -> list[Path]:
    """Return the files in a folder and below, sorted."""
    return sorted(path for path in folder.rglob("*") if path.is_file())


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def is_compiled(path: Path) -> bool:
    """Say whether an entry of the cache holds what a compiler made."""
    return path.name.startswith(("engines", "kernels", "loops"))


def run(*command: str | Path, cwd: str | Path | None = None) -> str:
    """Run a command and return what it prints; one that fails ends the release with what it said."""
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))} failed:\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def processor_time() -> float:
    """Return the processor time (s) of all commands that have ended."""
    of_commands = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of_commands.ru_utime + of_commands.ru_stime


def since(began: float) -> str:
    """Return how long ago something began."""
    return f"{time.monotonic() - began:.0f} s of time"


def say(what: str) -> None:
    """Say what is made next."""
    print(f"== {what}", flush=True)


if __name__ == "__main__":
    main()
