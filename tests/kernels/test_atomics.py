"""What threads hand to each other is published with release and read with acquire."""

from __future__ import annotations

import re
import struct
from importlib import resources
from pathlib import Path

import numpy as np

import overview_dsp
from overview_dsp.kernels.atomics import acquired, load_acquire, publish, store_release
from overview_dsp.kernels.precompiled import is_outdated

PUBLISHED = (
    "RING_WRITTEN RING_READ HOST_WRITTEN HOST_READ APPLIED M_STRIKES ACTIVE_SLOT FADING_SLOT"
)

# of a 64-bit ARM instruction: the bits that say what it is, and their values
LOADS_ACQUIRE = ((0xFFFFFC00, 0xC8DFFC00), (0xFFFFFC00, 0xF8BFC000))  # ldar, ldapr
STORES_RELEASE = ((0xFFFFFC00, 0xC89FFC00),)  # stlr
STORES = {0xF9000000: 1, 0xF8000000: 1, 0xFD000000: 1, 0xFC000000: 1, 0xA9000000: 2}
"""Words that `str`, `stur` (of integers, of numbers) and `stp` store, by their upper bits."""


def arms_instructions(*names):
    """The instructions, 32 bits each, of functions in what is shipped for 64-bit ARM.

    There loads and stores may be reordered; on x86 they aren't. Names as they are mangled.
    """
    assert not is_outdated(), "python tools/build_kernels.py"
    objects = resources.files("overview_dsp.kernels") / "objects"
    data = (objects / "linux-aarch64.o").read_bytes()
    # an ELF file's table of sections, and in it that of symbols: value and size of a function
    (at,) = struct.unpack_from("<Q", data, 0x28)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, at + size * i) for i in range(count)]
    symbols = next(one for one in sections if one[1] == 2)
    strings = sections[symbols[6]][4]
    found = []
    for entry in range(symbols[4], symbols[4] + symbols[5], 24):
        word, _, _, section, value, length = struct.unpack_from("<IBBHQQ", data, entry)
        mangled = data[strings + word :].partition(b"\0")[0].decode()
        if any(name in mangled for name in names):
            found.append(data[sections[section][4] + value :][:length])
    assert len(found) == len(names)
    return np.frombuffer(b"".join(found), "<u4")


def those(words, kinds):
    """Whether each instruction is one of these kinds."""
    return np.logical_or.reduce([(words & mask) == value for mask, value in kinds])


def test_the_callback_has_arms_barriers():
    callback = arms_instructions("8callback8callback", "5block7process")
    # counters of hands and of changes, each where events are applied and where the next is sought
    assert those(callback, LOADS_ACQUIRE).sum() >= 4
    # read and applied events, changes, strikes, the slots that sound and fade
    assert those(callback, STORES_RELEASE).sum() >= 6


def test_a_push_is_published_after_everything_else_is_written():
    push = arms_instructions("12entry_points4push")
    (published,) = np.flatnonzero(those(push, STORES_RELEASE))
    room = np.flatnonzero(those(push, LOADS_ACQUIRE))[0]
    # its time, its angle, whether it touches
    between = push[room:published] & 0xFFC00000
    assert sum(STORES.get(int(one), 0) for one in between) >= 3


def test_no_published_column_is_written_plainly():
    package = Path(overview_dsp.__file__).parent
    for path in [*(package / "kernels").rglob("*.py"), package / "signal" / "engine" / "queues.py"]:
        for name in PUBLISHED:
            plain = re.search(
                rf"i64\[layout\.{name}\b[^\]]*\] *[-+]?= ", path.read_text(encoding="utf-8")
            )
            assert plain is None, (path.name, plain)


def test_python_loads_and_stores_the_same_compiled_and_plain():
    columns = np.arange(8)
    publish(columns, 3, -5)
    assert acquired(columns, 3) == load_acquire(columns, 3) == -5
    store_release(columns, 3, 1 << 62)
    assert acquired(columns, 3) == 1 << 62
    assert columns.tolist() == [0, 1, 2, 1 << 62, 4, 5, 6, 7]
