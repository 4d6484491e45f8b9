"""Python's side of the page's sound: the memory it starts from, and what changes it later.

Who computes what. Everything that turns a timeline and a preset into numbers is computed here, by
the code that a native engine runs: coefficients, friction tables, events, modes, the actuator. The
page computes nothing: its audio thread copies these bytes into the kernel's memory and pushes
events into the kernel's rings; gliding, crossfading and all sound happen in the kernel. So the
page's samples are the native ones, bit for bit, and a static folder holds files of these bytes,
one a preset and sample rate. What only the page can know, the device's gain, mute, delay and
ceiling (after everything that is recorded), it sets itself in the kernel's memory.

The bytes, little-endian, in columns of 8:

    digest of the memory layout; int32 kind, int32 n; float64 sample_time (-1 = at once);
    float64 sample_rate; float64 channels (of a `WHOLE`'s output, else 0);
    n pairs of float64: what to change in the kernel, value;
    runs: int32 how, int32 columns, then
        FILL: the one value; DATA: as many values; TABLE: values, without the slopes between them;
        INTEGRAL: nothing, it is that of the friction table before it

The runs of a `WHOLE` cover the memory, those of a `CHANGE` a surface slot or nothing. Slopes are
differences of neighbours, the integral is a running sum of their means: IEEE arithmetic gives the
page the same bits.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.gestures import SOURCES
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels import layout, memory_image
from overview_dsp.kernels.memory_image import CHANGE, DATA, FILL, INTEGRAL, TABLE, WHOLE
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import connect
from overview_dsp.signal.engine.coefficients import changes, check_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.queues import stamp_of
from overview_dsp.signal.engine.surface_slots import timeline_events, write_surface
from overview_dsp.signal.surface.model import Surface

LEAST_FILL = 4
"""Equal columns from which a run of its own is shorter than the values."""

TABLE_COLUMNS = 2 * (layout.CELLS + 1)
TABLES = (layout.SLOT_TABLE, layout.SLOT_SLIDING_TORQUE, layout.SLOT_PULL)


def layout_numbers() -> dict[str, int]:
    """Every offset, capacity and code of the memory layout, by its name."""
    return {
        name: value
        for name, value in vars(layout).items()
        if name.isupper() and isinstance(value, int)
    }


def encoding_numbers() -> dict[str, int]:
    """The numbers of the encoding itself, by their names."""
    names = "HEAD WHOLE CHANGE FILL DATA TABLE INTEGRAL INTEGRAL_FROM_TABLE"
    return {name: getattr(memory_image, name) for name in names.split()}


def layout_digest() -> bytes:
    """8 bytes that differ where the layout, the encoding or the order of the sources does."""
    text = f"{layout_numbers()} {encoding_numbers()} {SOURCES}"
    return hashlib.sha256(text.encode()).digest()[:8]


def encode_engine(engine: Engine, settings: OutputSettings | None = None) -> bytes:
    """Encode a prepared engine's memory, for the same kernel in a browser.

    It is connected to an output as `live` connects it; a page that loads it sounds on exactly as
    the engine would.

    Parameters
    ----------
    engine : Engine
        Prepared; it goes on from where it is.
    settings : OutputSettings or None
        Channels, gains, delays and ceilings of the page's output, and its actuator.

    Returns
    -------
    bytes
        What `kernel_node.js` starts from, some 0.5 MB.

    Raises
    ------
    NotPreparedError
        Before `prepare`.
    InputError
        A sample rate too low for the settings' actuator.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> memory = ov.export.encode_engine(engine)
    >>> len(memory) < 1_000_000
    True
    """
    channels = connect(engine, settings)
    bits = engine.memory.view(np.uint64)
    head = _head(WHOLE, [], stamp_of(None), engine.sample_rate, channels)
    parts = [head, _runs(bits[: layout.SURFACES])]
    for slot in range(layout.SLOTS):
        start = layout.SURFACES + slot * layout.SLOT_SIZE
        parts.append(_slot(bits[start : start + layout.SLOT_SIZE]))
    return b"".join(parts)


def encode_change(
    before: Preset,
    after: Preset,
    sample_rate: float,
    surface: Surface | None = None,
    sample_time: int | None = None,
) -> bytes:
    """From one preset's parameters to another's, and to a new surface if one is given.

    What `Engine.set`, `set_preset`, `set_timeline` and `set_surface` do, for a page: parameters
    glide and the surface is crossfaded from `sample_time` on; None is as soon as possible.

    Raises
    ------
    InputError
        The carrier doesn't fit the sample rate (Hz), or no such sample time.
    """
    check_carrier(after, sample_rate)
    changed = changes(before, after, sample_rate)
    head = _head(CHANGE, changed, stamp_of(sample_time), sample_rate)
    if surface is None:
        return head
    m = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    m[layout.S_SAMPLE_RATE] = sample_rate
    write_surface(m, 0, surface)
    return head + _slot(m[layout.SURFACES :].view(np.uint64))


def event_numbers(surface: Surface) -> list[int]:
    """The timeline's event of each number that a strike in the page may name.

    -1 is the base surface, which is struck as number -1 too.
    """
    return [int(event) for event in timeline_events(surface)[:-1]]


def _head(
    kind: int,
    changed: list[tuple[int, float]],
    sample_time: int,
    sample_rate: float,
    channels: int = 0,
) -> bytes:
    numbers = np.array([kind, len(changed)], dtype="<i4")
    pairs = [number for pair in changed for number in pair]
    rest = np.array([sample_time, sample_rate, channels, *pairs], dtype="<f8")
    return layout_digest() + numbers.tobytes() + rest.tobytes()


def _run(how: int, columns: int, values: NDArray[np.uint64]) -> bytes:
    return np.array([how, columns], dtype="<i4").tobytes() + values.astype("<u8").tobytes()


def _slot(bits: NDArray[np.uint64]) -> bytes:
    """The runs of a surface slot."""
    parts = []
    at = 0
    for start in TABLES:
        parts.append(_runs(bits[at:start]))
        at = start + TABLE_COLUMNS
        parts.append(_table(bits[start:at]))
        if start == layout.SLOT_TABLE:
            # which lies behind its table (`layout`)
            at = layout.SLOT_INTEGRAL + layout.CELLS + 1
            parts.append(_integral(bits[layout.SLOT_INTEGRAL : at], bits[start::2]))
    return b"".join([*parts, _runs(bits[at:])])


def _table(bits: NDArray[np.uint64]) -> bytes:
    values = bits[0::2].copy()
    slopes = np.append(np.diff(values.view(np.float64)), 0.0)
    if (bits == bits[0]).all() or not np.array_equal(slopes.view(np.uint64), bits[1::2]):
        return _runs(bits)
    return _run(TABLE, len(bits), values)


def _integral(bits: NDArray[np.uint64], table: NDArray[np.uint64]) -> bytes:
    values = table[: len(bits)].view(np.float64)
    sums = np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1])))
    if (bits == bits[0]).all() or not np.array_equal(sums.view(np.uint64), bits):
        return _runs(bits)
    return _run(INTEGRAL, len(bits), bits[:0])


def _runs(bits: NDArray[np.uint64]) -> bytes:
    """Long stretches of one value as fills, what is between them as data."""
    edges = np.flatnonzero(bits[1:] != bits[:-1]) + 1
    starts = np.concatenate([[0], edges])
    stops = np.concatenate([edges, [len(bits)]])
    parts = []
    at = 0
    long = stops - starts >= LEAST_FILL
    for start, stop in zip(starts[long].tolist(), stops[long].tolist(), strict=True):
        if at < start:
            parts.append(_run(DATA, start - at, bits[at:start]))
        parts.append(_run(FILL, stop - start, bits[start : start + 1]))
        at = stop
    if at < len(bits):
        parts.append(_run(DATA, len(bits) - at, bits[at:]))
    return b"".join(parts)
