"""JACK's own library, which answers what PortAudio doesn't: clients and connections.

Each call opens a client without ports for some milliseconds. A server that is frozen delays it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import takewhile
from typing import Any

_NO_START_SERVER = 1
_IS_OUTPUT = 2

Connections = list[list[bytes]]
"""Names of the ports that each output port of a client is connected to, by channel."""


@contextmanager
def _client() -> Iterator[tuple[Any, Any]]:
    """Open a client; yield the library and the client. Both are None without a server."""
    try:
        library = ctypes.CDLL("libjack.so.0")
    except OSError:
        yield None, None
        return
    for name in ("client_open", "get_uuid_for_client_name", "port_by_name"):
        getattr(library, f"jack_{name}").restype = ctypes.c_void_p
    for name in ("get_ports", "port_get_all_connections"):
        getattr(library, f"jack_{name}").restype = ctypes.POINTER(ctypes.c_char_p)
    client = library.jack_client_open(b"overview-look", _NO_START_SERVER, None)
    if client is None:
        yield None, None
        return
    handle = ctypes.c_void_p(client)
    try:
        yield library, handle
    finally:
        library.jack_client_close(handle)


def has_client(name: bytes) -> bool:
    """Return whether a server runs that has a client of this name."""
    with _client() as (library, client):
        if library is None:
            return False
        uuid = library.jack_get_uuid_for_client_name(client, name)
        if uuid is not None:
            library.jack_free(ctypes.c_void_p(uuid))
        return uuid is not None


def _names(library: Any, found: Any) -> list[bytes]:
    """Return the names in a list that ends with NULL, and free it."""
    if not found:
        return []
    names = list(takewhile(lambda name: name is not None, found))
    library.jack_free(found)
    return names


def _outputs(library: Any, client: Any, name: bytes) -> Iterator[tuple[bytes, list[bytes]]]:
    """Yield the output ports of a client, by channel, each with its connections."""
    for port in _names(library, library.jack_get_ports(client, None, None, _IS_OUTPUT)):
        if port.startswith(name + b":"):
            handle = ctypes.c_void_p(library.jack_port_by_name(client, port))
            found = library.jack_port_get_all_connections(client, handle)
            yield port, _names(library, found)


def connections(name: bytes) -> Connections:
    """Return the connections of the output ports of a client; empty without a server."""
    with _client() as (library, client):
        return [] if library is None else [one for _, one in _outputs(library, client, name)]


def connect(name: bytes, required: Connections) -> None:
    """Give the output ports of a client these connections, and no others."""
    with _client() as (library, client):
        if library is None:
            return
        for (port, present), others in zip(_outputs(library, client, name), required, strict=False):
            for other in set(present) - set(others):
                library.jack_disconnect(client, port, other)
            for other in set(others) - set(present):
                library.jack_connect(client, port, other)
