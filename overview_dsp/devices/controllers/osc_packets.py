"""OSC datagrams to messages and back, by python-osc, which is imported here alone, and late."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from overview_dsp.errors import InputError, OverviewError

HINT = "OSC needs python-osc: pip install 'overview-dsp[osc]'"


def require_osc() -> None:
    """Raise OverviewError, which says what to install, if there is no python-osc.

    From here on it is also kept from writing to the terminal about each type it doesn't know.
    """
    try:
        import pythonosc  # noqa: F401
    except ImportError:
        raise OverviewError(HINT) from None
    root = logging.getLogger()
    if _is_ours not in root.filters:
        root.addFilter(_is_ours)


def _is_ours(record: logging.LogRecord) -> bool:
    return "pythonosc" not in record.pathname


def decode_packet(data: bytes) -> list[tuple[str, Sequence[Any]]]:
    """The messages (address, values) of a datagram, those of its bundles in order of their times.

    Raises
    ------
    InputError
        It is none.
    """
    from pythonosc.osc_packet import OscPacket

    if len(data) % 4:  # python-osc fills a cut number up with zeros
        raise InputError(f"{len(data)} bytes that are no OSC (its packets are whole fours)")
    try:
        return [(one.message.address, one.message.params) for one in OscPacket(data).messages]
    # what else a damaged one makes of the decoder: of texts, of nested bundles, of sizes
    except Exception as error:
        raise InputError(f"{len(data)} bytes that are no OSC ({_first_line(error)})") from None


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:80]


def encode_message(address: str, values: Sequence[bool | int | float | str]) -> bytes:
    """A datagram with one message: numbers in single precision, texts in UTF-8."""
    from pythonosc.osc_message_builder import OscMessageBuilder

    builder = OscMessageBuilder(address=address)
    for value in values:
        builder.add_arg(value)
    return bytes(builder.build().dgram)
