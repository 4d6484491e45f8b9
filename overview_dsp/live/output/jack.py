"""JACK's own library, which answers what PortAudio doesn't: clients of the server.

Each call opens a client without ports for some milliseconds. A server that is frozen delays it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_NO_START_SERVER = 1


@contextmanager
def _client() -> Iterator[tuple[Any, Any]]:
    """Open a client; yield the library and the client. Both are None without a server."""
    try:
        library = ctypes.CDLL("libjack.so.0")
    except OSError:
        yield None, None
        return
    library.jack_client_open.restype = ctypes.c_void_p
    library.jack_get_uuid_for_client_name.restype = ctypes.c_void_p
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
