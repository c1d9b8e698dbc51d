"""Rotors that come with the package, by name: the rig of the thesis and two of the literature."""

from __future__ import annotations

from pathlib import Path

from amb_files.suggestions import suggest

FOLDER = Path(__file__).parent / "rotors"
DEFAULT_ROTOR = FOLDER / "bath_rig_thesis.toml"


def packaged_rotors() -> dict[str, Path]:
    """Return the files of the rotors that come with the package, by name."""
    return {file.stem: file for file in sorted(FOLDER.glob("*.toml"))}


def rotor_path(rotor: str | Path = DEFAULT_ROTOR) -> Path:
    """Return the file of a rotor that comes with the package, or the path as it is.

    Parameters
    ----------
    rotor
        The name of a rotor, such as `compressor`, or the path of a rotor file.

    Raises
    ------
    ValueError
        If it is neither; the message suggests names. A path that ends in `.toml` is not looked at.
    """
    packaged, path = packaged_rotors(), Path(rotor)
    if str(rotor) in packaged:
        return packaged[str(rotor)]
    if path.suffix != ".toml" and not path.exists():
        raise ValueError(f"no rotor {str(rotor)!r}; {suggest(path.name, packaged)}")
    return path
