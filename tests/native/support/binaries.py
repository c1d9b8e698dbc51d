"""What shared libraries export and ask for: ELF, PE and Mach-O, as LIEF reads them."""

from dataclasses import dataclass

import lief

lief.logging.disable()


@dataclass
class Binary:
    """Processor, exported and imported names, libraries, and the required versions of these."""

    processor: str
    exports: set[str]
    imports: set[str]
    libraries: set[str]
    versions: set[str]


def read(content: bytes) -> list[Binary]:
    """Return one entry for a plain library, one per processor for a universal one."""
    if (file := lief.MachO.parse(content)) is None:
        return [_facts(lief.parse(content))]
    return [_facts(binary) for binary in file]


def _facts(binary: lief.Binary) -> Binary:
    if isinstance(binary, lief.PE.Binary):
        exports, imports = binary.get_export().entries, binary.imported_functions
    else:
        exports, imports = binary.exported_symbols, binary.imported_symbols
    requested = binary.symbols_version_requirement if isinstance(binary, lief.ELF.Binary) else ()
    mark = "_" if isinstance(binary, lief.MachO.Binary) else ""  # before each name of C
    return Binary(
        binary.abstract.header.architecture.name,
        {symbol.name.removeprefix(mark) for symbol in exports},
        {symbol.name.removeprefix(mark) for symbol in imports},
        set(binary.abstract.libraries),
        {version.name for library in requested for version in library.get_auxiliary_symbols()},
    )
