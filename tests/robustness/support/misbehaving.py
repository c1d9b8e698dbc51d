"""Servers that do not do what a Dask scheduler does: of their own, or between a client and a scheduler."""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

GREETINGS = (
    b"",
    b"HTTP/1.1 400 Bad Request\r\n\r\n",
    b"SSH-2.0-OpenSSH_9.2\r\n",
    b"\x16\x03\x03\x00\x7a\x02\x00\x00\x76\x03\x03",  # of TLS
    struct.pack("<Q", 1),
    struct.pack("<QQ", 1, 2**60),  # a message of so many bytes
    struct.pack("<Q", 2**60),  # so many messages
    struct.pack("<QQQ", 24, 1, 8) + b"\x80\x04N.\0\0\0\0",
    b"\0" * 4096,
    b"\xff" * 4096,
)
DEEDS = CLOSE, RESET, STALL = range(3)  # what a connection does after so many bytes
PAUSE = 0.02  # s between the bytes of a server that trickles


@contextmanager
def served(answer: Callable[[socket.socket], None]) -> Iterator[str]:
    """Serve with a thread for each connection; yields `host:port`."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def accept() -> None:
            with suppress(OSError):
                while True:
                    connection, _ = server.accept()
                    threading.Thread(target=guarded, args=(connection,), daemon=True).start()

        def guarded(connection: socket.socket) -> None:
            with suppress(OSError):
                answer(connection)

        threading.Thread(target=accept, daemon=True).start()
        try:
            yield f"127.0.0.1:{server.getsockname()[1]}"
        finally:
            with suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)


def reset(connection: socket.socket) -> None:
    """Close a connection without a farewell."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def wrong_protocol(chance: random.Random) -> Callable[[socket.socket], None]:
    """Answer with a greeting, with other bytes in it or without, at once or in drops, and stay, leave or vanish."""
    said = bytearray(chance.choice(GREETINGS))
    if chance.random() < 0.5:
        at = chance.randrange(len(said) + 1)
        said[at:at] = chance.randbytes(chance.randrange(200))
    trickles, end, waits = chance.random() < 0.2, chance.choice((CLOSE, RESET, STALL)), chance.random() < 0.5

    def answer(connection: socket.socket) -> None:
        if waits:
            connection.recv(1)
        for part in [said[k : k + 1] for k in range(len(said))] if trickles else [said]:
            connection.sendall(part)
            time.sleep(PAUSE if trickles else 0.0)
        if end == RESET:
            reset(connection)
        elif end == CLOSE:
            connection.close()
        else:
            while connection.recv(65536):
                pass

    return answer


def between(host: str, port: int, left: list[int], deed: int) -> Callable[[socket.socket], None]:
    """Pass on what a client and a scheduler say to each other, until `left[0]` bytes of the scheduler have passed.

    The number counts down, so that the caller sees how many have passed.
    """

    def answer(client: socket.socket) -> None:
        scheduler = socket.create_connection((host, port))

        def pass_on(source: socket.socket, target: socket.socket, counts: bool) -> None:
            with suppress(OSError):
                while content := source.recv(4096):
                    left[0] -= len(content) if counts else 0
                    if counts and left[0] <= 0:
                        if deed == STALL:
                            continue
                        (reset if deed == RESET else socket.socket.close)(client)
                        scheduler.close()
                        return
                    target.sendall(content)
            for end in (source, target):
                with suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)

        threading.Thread(target=pass_on, args=(client, scheduler, False), daemon=True).start()
        pass_on(scheduler, client, True)

    return answer
