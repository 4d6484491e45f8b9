"""What a request says about where it comes from: the Host it asked, the Origin it was sent by.

A foreign page can make a browser send requests here. The Host check stops one whose name was
pointed at this machine (DNS rebinding), the Origin check everything else that could change or read
something.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Collection, Mapping

PORTS = {"http": 80, "ws": 80, "https": 443, "wss": 443}
PAGE_SCHEME = {"http": "http", "ws": "http", "https": "https", "wss": "https"}


def host_is_ours(
    host: str, scheme: str, arrived_at: tuple[str, int], names: Collection[str]
) -> bool:
    """Whether a Host header names the very address a request arrived at, or one of `names`."""
    name, port = _parts(host, PORTS[scheme])
    address = _address(arrived_at[0])
    if name is None or port != arrived_at[1] or address is None:
        return False
    literal = _address(name)
    if literal is not None:
        return literal == address
    return name in names or (name == "localhost" and address.is_loopback)


def origin_is_ours(headers: Mapping[str, str], scheme: str, must_be_given: bool) -> bool:
    """Whether a request was sent by a page of ours (`Origin`, `Sec-Fetch-Site`).

    The Host header must have been found ours before.
    """
    origin = headers.get("origin")
    if origin is None:
        if must_be_given:
            return False
    elif origin.lower() != f"{PAGE_SCHEME[scheme]}://{headers.get('host', '').lower()}":
        return False
    return headers.get("sec-fetch-site", "same-origin") in ("same-origin", "none")


def _parts(host: str, default: int) -> tuple[str | None, int]:
    """Name (lower case, without brackets) and port of a Host header; no name if it isn't one."""
    name, colon, port = host.lower().rpartition(":")
    if not colon or name.count("[") != name.count("]"):  # no port, or a colon inside brackets
        name, port = host.lower(), str(default)
    if name.startswith("[") and name.endswith("]"):
        name = name[1:-1]
    elif ":" in name:
        return None, 0
    if not (port.isascii() and port.isdecimal() and len(port) <= 5):
        return None, 0
    return name, int(port)


def _address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        found = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    mapped = found.ipv4_mapped if isinstance(found, ipaddress.IPv6Address) else None
    return mapped or found
