"""Streams as devices send them, and what happens to them on the way."""

from __future__ import annotations

import itertools

from hypothesis import strategies as st

from tests.devices.sensors.encoding import encode_frame

int16 = st.integers(-32768, 32767)
int32 = st.integers(-(1 << 31), (1 << 31) - 1)


@st.composite
def frame_arguments(draw):
    kind = draw(st.integers(1, 7))
    byte, uint16 = st.integers(0, 255), st.integers(0, 65535)
    sizes = {1: (int16,) * 3, 2: (int16,) * 6, 6: (int32, int32, int16, int16),
             7: (uint16,) * 3 + (byte,) * 4 + (uint16,)}  # fmt: skip
    values = draw(st.tuples(*sizes.get(kind, (int32,))))
    return kind, draw(st.integers(0, 65535)), draw(st.integers(0, (1 << 32) - 1)), values


def frame_stream(count: int, start: int = 0) -> list[bytes]:
    """Frames of six axes, no two alike."""
    return [
        encode_frame(2, n, 1000 * n, (n, -n, 2048, 7 * n % 999, 0, -3))
        for n in range(start, start + count)
    ]


def cut(data: bytes, places: list[int]) -> list[bytes]:
    """`data` in pieces."""
    at = sorted({0, len(data), *(place % (len(data) + 1) for place in places)})
    return [data[a:b] for a, b in itertools.pairwise(at)]


def flip(data: bytes, first_bit: int, pattern: int) -> bytes:
    """`data` with the bits of `pattern` flipped, in the order a UART sends bits."""
    as_number = int.from_bytes(data, "little") ^ pattern << first_bit
    return as_number.to_bytes(len(data), "little")


places = st.lists(st.integers(0, 10_000), max_size=20)

damages = st.lists(
    st.one_of(
        st.tuples(st.just("change"), st.integers(0, 10_000), st.integers(0, 255)),
        st.tuples(st.just("drop"), st.integers(0, 10_000), st.integers(1, 40)),
        st.tuples(st.just("repeat"), st.integers(0, 10_000), st.integers(1, 60)),
        st.tuples(st.just("insert"), st.integers(0, 10_000), st.binary(max_size=30)),
    ),
    max_size=8,
)


def harm(data: bytes, damages: list[tuple]) -> bytes:
    """`data` with bytes changed, dropped, repeated and put in."""
    for what, place, how in damages:
        at = place % (len(data) + 1)
        if what == "change" and at < len(data):
            data = data[:at] + bytes([how]) + data[at + 1 :]
        elif what == "drop":
            data = data[:at] + data[at + how :]
        elif what == "repeat":
            data = data[: at + how] + data[at:]
        elif what == "insert":
            data = data[:at] + how + data[at:]
    return data
