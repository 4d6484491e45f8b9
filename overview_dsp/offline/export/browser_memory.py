"""Memory images for the browser: initial memory of the page's kernel, and later changes.

Python derives all numbers from a timeline and a preset, with the code of a native engine:
coefficients, friction tables, events, modes, and the actuator. The page's audio thread only copies
these bytes to the kernel's memory and pushes events to the kernel's rings. Smoothing, crossfades
and all sound are computed by the kernel. The page's samples are thus bit-identical to native ones,
and a static folder has one file of these bytes per preset and sample rate. The page itself sets the
device's gain, mute, delay and ceiling, which are not recorded, in the kernel's memory.

The bytes, little-endian, in columns of 8:

    digest of the memory layout; int32 kind, int32 n; float64 sample_time (-1 = at once);
    float64 sample_rate; float64 channels (of a `WHOLE`'s output, else 0);
    n pairs of float64: target of a change in the kernel, value;
    runs: int32 how, int32 columns, then
        FILL: one value; DATA: as many values; TABLE: values, without the slopes between them;
        INTEGRAL: nothing, since it is computed from the preceding friction table

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
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout, memory_image
from overview_dsp.kernels.memory_image import CHANGE, DATA, FILL, INTEGRAL, TABLE, WHOLE
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import connect
from overview_dsp.signal.engine.coefficients import changes, check_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.queues import stamp_of
from overview_dsp.signal.engine.surface_slots import timeline_events, write_surface
from overview_dsp.signal.surface.model import Surface

LEAST_FILL = 4  # number of equal columns from which on a separate run is shorter
TABLE_COLUMNS = 2 * (layout.CELLS + 1)
TABLES = (layout.SLOT_TABLE, layout.SLOT_SLIDING_TORQUE, layout.SLOT_PULL)


def layout_numbers() -> dict[str, int]:
    """Return all offsets, capacities and codes of the memory layout by name."""
    return {
        name: value
        for name, value in vars(layout).items()
        if name.isupper() and isinstance(value, int)
    }


def encoding_numbers() -> dict[str, int]:
    """Return the numbers of the encoding by name."""
    names = "HEAD WHOLE CHANGE FILL DATA TABLE INTEGRAL INTEGRAL_FROM_TABLE"
    return {name: getattr(memory_image, name) for name in names.split()}


def layout_digest() -> bytes:
    """Return an 8-byte digest of the layout, the encoding and the order of the sources."""
    text = f"{layout_numbers()} {encoding_numbers()} {SOURCES}"
    return hashlib.sha256(text.encode()).digest()[:8]


def encode_engine(engine: Engine, settings: OutputSettings | None = None) -> bytes:
    """Encode a prepared engine's memory, for the same kernel in a browser.

    It is connected to an output as in `live`. A page that loads it continues exactly like
    the engine.

    Parameters
    ----------
    engine : Engine
        Prepared engine with its present state.
    settings : OutputSettings or None
        Channels, gains, delays and ceilings of the page's output, and its actuator.

    Returns
    -------
    bytes
        Initial memory of `kernel_node.js`, about 0.5 MB.

    Raises
    ------
    NotPreparedError
        Before `prepare`.
    InputError
        The sample rate is too low for the settings' actuator, or they have several tactors.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> memory = ov.export.encode_engine(engine)
    >>> len(memory) < 1_000_000
    True
    """
    if settings is not None and len(settings.tactor.tactors) > 1:
        raise InputError("a page has one tactor; use + between its channels (3+4)")
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
    """Encode a change between two presets' parameters and, optionally, to a new surface.

    It corresponds to `Engine.set`, `set_preset`, `set_timeline` and `set_surface`: parameters are
    smoothed and the surface is crossfaded from `sample_time` on; None is as soon as possible.
    InputError for a carrier that doesn't fit the sample rate (Hz), or an invalid sample time.
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
    """Return the timeline's event for each number of a strike on the page.

    -1 is the base surface, whose strikes also have the number -1.
    """
    return [int(event) for event in timeline_events(surface)[:-1]]


def _head(
    kind: int, changed: list[tuple[int, float]], sample_time: int, rate: float, channels: int = 0
) -> bytes:
    numbers = np.array([kind, len(changed)], dtype="<i4")
    pairs = [number for pair in changed for number in pair]
    rest = np.array([sample_time, rate, channels, *pairs], dtype="<f8")
    return layout_digest() + numbers.tobytes() + rest.tobytes()


def _run(how: int, columns: int, values: NDArray[np.uint64]) -> bytes:
    return np.array([how, columns], dtype="<i4").tobytes() + values.astype("<u8").tobytes()


def _slot(bits: NDArray[np.uint64]) -> bytes:
    """Return the runs of a surface slot."""
    parts = []
    at = 0
    for start in TABLES:
        parts.append(_runs(bits[at:start]))
        at = start + TABLE_COLUMNS
        parts.append(_table(bits[start:at]))
        if start == layout.SLOT_TABLE:
            # it follows its table (`layout`)
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
    """Return runs: fills for long sequences of equal values, data otherwise."""
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
