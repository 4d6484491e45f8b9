"""OSC datagrams by the specification (OSC 1.0), without the library that the package uses."""

from __future__ import annotations

import struct


def text(said):
    data = said.encode() + b"\0"
    return data + bytes(-len(data) % 4)


def message(address, *values):
    tags, data = ",", b""
    for value in values:
        if isinstance(value, bool):
            tags += "T" if value else "F"
        elif isinstance(value, int):
            tags, data = tags + "i", data + struct.pack(">i", value)
        elif isinstance(value, float):
            tags, data = tags + "f", data + struct.pack(">f", value)
        else:
            tags, data = tags + "s", data + text(value)
    return text(address) + text(tags) + data


def bundle(*parts, seconds=0):
    """`seconds`: when, s since 1970; 0 is at once."""
    ntp = int((seconds + 2_208_988_800) * 2**32) if seconds else 1
    stamp = struct.pack(">Q", ntp)
    return b"#bundle\0" + stamp + b"".join(struct.pack(">i", len(one)) + one for one in parts)


def messages(datagram):
    """The messages (address, values) of a datagram with one of them."""

    def text_at(at):
        end = datagram.index(b"\0", at)
        return datagram[at:end].decode(), at + (end - at) // 4 * 4 + 4

    address, at = text_at(0)
    tags, at = text_at(at)
    values = []
    for tag in tags[1:]:
        if tag == "s":
            value, at = text_at(at)
            values.append(value)
        else:
            values.append(struct.unpack_from({"f": ">f", "i": ">i"}[tag], datagram, at)[0])
            at += 4
    return address, values
