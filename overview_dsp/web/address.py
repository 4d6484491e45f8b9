"""Where the server is reached: addresses and names of this machine, the address to open, its QR."""

from __future__ import annotations

import io
import ipaddress
import socket

ANYWHERE = {4: "192.0.2.1", 6: "2001:db8::1"}
"""Addresses of documents: our address on the route to one is the one the network uses."""


def is_loopback(host: str) -> bool:
    """Whether a host to listen on is only reached from this machine."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def own_names() -> frozenset[str]:
    """This machine's names, as networks know them."""
    name = socket.gethostname().lower()
    return frozenset({name, f"{name.partition('.')[0]}.local"} - {"", ".local"})


def reached_at(host: str) -> str:
    """The address by which others reach a server that listens on `host`."""
    try:
        found = ipaddress.ip_address(host)
    except ValueError:
        return host
    if not found.is_unspecified:
        return host
    family = socket.AF_INET6 if found.version == 6 else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((ANYWHERE[found.version], 9))  # a datagram socket: nothing is sent
            return str(probe.getsockname()[0])
        except OSError:  # no network
            return "::1" if found.version == 6 else "127.0.0.1"


def page_address(scheme: str, host: str, port: int, token: str) -> str:
    """The address to open; the token stands where browsers don't send it."""
    name = f"[{host}]" if ":" in host else host
    return f"{scheme}://{name}:{port}/#token={token}"


def qr_text(address: str) -> str:
    """An address as a QR code for a terminal."""
    import segno

    out = io.StringIO()
    segno.make(address, error="l", micro=False).terminal(out, compact=True)
    return out.getvalue()
