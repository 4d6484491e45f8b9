"""JACK's own library, which answers what PortAudio doesn't: clients and connections.

Its questions wait for a server that is frozen.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from itertools import takewhile
from typing import Any

_NO_START_SERVER = 1
_IS_OUTPUT = 2

Connections = list[list[bytes]]
"""Names of the ports that each output port of a client is connected to, by channel."""


class _Watch:
    """Client without ports on the server of PortAudio's client, never on a later one."""

    library: Any = None
    client: ctypes.c_void_p | None = None


def watch_server() -> None:
    """Open the client that asks the present server, in place of one whose server has died.

    PortAudio has connected to this server by now. libjack closes the clients of a dead server at
    that moment. Without libjack there are no answers.
    """
    _Watch.client = None
    try:
        library = _Watch.library = ctypes.CDLL("libjack.so.0")
    except OSError:
        return
    for name in ("client_open", "get_uuid_for_client_name", "port_by_name"):
        getattr(library, f"jack_{name}").restype = ctypes.c_void_p
    for name in ("get_ports", "port_get_all_connections"):
        getattr(library, f"jack_{name}").restype = ctypes.POINTER(ctypes.c_char_p)
    client = library.jack_client_open(b"overview-look", _NO_START_SERVER, None)
    _Watch.client = None if client is None else ctypes.c_void_p(client)


def has_client(name: bytes) -> bool:
    """Return whether the watched server still runs and has a client of this name."""
    if _Watch.client is None:
        return False
    uuid = _Watch.library.jack_get_uuid_for_client_name(_Watch.client, name)
    if uuid is not None:
        _Watch.library.jack_free(ctypes.c_void_p(uuid))
    return uuid is not None


def _names(found: Any) -> list[bytes]:
    """Return the names in a list that ends with NULL, and free it."""
    if not found:
        return []
    names = list(takewhile(lambda name: name is not None, found))
    _Watch.library.jack_free(found)
    return names


def _outputs(name: bytes) -> Iterator[tuple[bytes, list[bytes]]]:
    """Yield the output ports of a client, by channel, each with its connections."""
    if not has_client(name):
        return
    library, client = _Watch.library, _Watch.client
    for port in _names(library.jack_get_ports(client, None, None, _IS_OUTPUT)):
        if port.startswith(name + b":"):
            handle = ctypes.c_void_p(library.jack_port_by_name(client, port))
            yield port, _names(library.jack_port_get_all_connections(client, handle))


def connections(name: bytes) -> Connections:
    """Return the connections of the output ports of a client; empty without its server."""
    return [found for _, found in _outputs(name)]


def connect(name: bytes, required: Connections) -> list[str]:
    """Give the output ports of a client these connections; return those that are missing.

    A port all of whose connections are missing keeps the present ones.
    """
    library, client = _Watch.library, _Watch.client
    missing = []
    for (port, present), others in zip(_outputs(name), required, strict=False):
        found = {other for other in others if library.jack_port_by_name(client, other)}
        missing += [other.decode(errors="replace") for other in others if other not in found]
        if others and not found:
            continue
        for other in set(present) - found:
            library.jack_disconnect(client, port, other)
        for other in found - set(present):
            library.jack_connect(client, port, other)
    return missing
