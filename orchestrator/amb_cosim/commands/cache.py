"""Command that shows and empties the cache."""

from __future__ import annotations

import time

import click

from amb_cosim.commands.cli_errors import refusing


@click.command()
@click.option("--clear", is_flag=True, help="Empty the cache; its content is rebuilt when needed.")
def cache(clear: bool) -> None:
    """Show or empty the cache of built files.

    The list shows when each was used last.
    """
    from amb_cosim.cosim.building.cache import LIMIT, cache_entries, remove_entries
    from amb_files.user_cache import user_cache

    with refusing():
        entries = remove_entries() if clear else cache_entries()
        size = sum(entry.size for entry in entries)
        for entry in () if clear else entries:
            day = time.strftime("%Y-%m-%d", time.localtime(entry.used))
            click.echo(f"{day} {entry.size / 2**20:8.1f} MB  {entry.path.name}")
        summary = f"{len(entries)} in {user_cache()}, {size / 2**20:.1f} MB"
        click.echo(
            f"removed {summary}"
            if clear
            else f"{summary}; if the cache exceeds {LIMIT / 2**30:g} GB, the least recently used files are removed"
        )


COMMANDS = (cache,)
