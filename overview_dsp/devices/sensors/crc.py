"""CRC-16/X-25 (the frame check of HDLC and PPP, RFC 1662 appendix C.2).

Polynomial x^16 + x^12 + x^5 + 1, least significant bit first, start and final XOR 0xFFFF; its check
value of b"123456789" is 0x906E. A polynomial of degree 16 with a constant term divides no burst of
up to 16 bits. Least significant bit first is the order in which a UART sends, so that a burst on
the wire is a burst in the code: a CRC the other way round sees up to 24 bits of it.
"""

from __future__ import annotations

POLYNOMIAL = 0x8408  # bit-reversed 0x1021


def _step(value: int) -> int:
    for _ in range(8):
        value = value >> 1 ^ (POLYNOMIAL if value & 1 else 0)
    return value


_TABLE = tuple(_step(value) for value in range(256))


def crc16(data: bytes | bytearray) -> int:
    """The check of `data`, 0 to 65535."""
    register = 0xFFFF
    for byte in data:
        register = register >> 8 ^ _TABLE[(register ^ byte) & 0xFF]
    return register ^ 0xFFFF
