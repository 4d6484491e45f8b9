"""What threads hand to each other is published with release and read with acquire."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import overview_dsp
from overview_dsp.kernels.ordering import acquired, load_acquire, publish, store_release

ROOT = Path(__file__).resolve().parents[2]
PUBLISHED = (
    "RING_WRITTEN RING_READ HOST_WRITTEN HOST_READ APPLIED M_STRIKES ACTIVE_SLOT FADING_SLOT"
)

# for a machine whose processor may reorder loads and stores; x86 doesn't
ASSEMBLY = """
import json, sys
import numba, numpy as np
from numba import types
from kernel_ir import machine_for, module_for, written_out
from overview_dsp.kernels import layout
from overview_dsp.kernels.control import push_control
from overview_dsp.kernels.device.callback import SIGNATURE, callback

def push(memory, stamp, theta2):
    f64 = numba.carray(memory, (layout.TOTAL,), np.float64)
    i64 = numba.carray(memory, (layout.TOTAL,), np.int64)
    return push_control(f64, i64, 0, stamp, theta2, True)

PUSH = types.boolean(types.voidptr, types.int64, types.float64)
entry = {sys.argv[1]: {"callback": (callback, SIGNATURE), "push": (push, PUSH)}[sys.argv[1]]}
machine = machine_for("aarch64-unknown-linux-gnu")
print(json.dumps(machine.emit_assembly(module_for(written_out(entry), machine, speed_level=1))))
"""


def instructions(name, cache):
    """Instructions of the native callback, or of a push from Python, for 64-bit ARM."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore:Cannot cache", "-c", ASSEMBLY, name],
        capture_output=True,
        text=True,
        check=False,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tools")]),
            "NUMBA_OPT": "0",
            "NUMBA_DISABLE_JIT": "0",
            "NUMBA_CACHE_DIR": str(cache),
        },
    )
    assert done.returncode == 0, done.stderr
    return re.findall(r"^\t([a-z]\w*)", json.loads(done.stdout.splitlines()[-1]), re.M)


@pytest.mark.skipif(
    os.environ.get("OVERVIEW_LONG") != "1",
    reason="compiles everything for another processor, 20 s: set OVERVIEW_LONG=1",
)
def test_the_callback_has_arms_barriers(tmp_path):
    callback = instructions("callback", tmp_path)
    acquires = callback.count("ldar") + callback.count("ldapr")
    # counters of hands and of changes, each where events are applied and where the next is sought
    assert acquires >= 4
    # read and applied events, changes, strikes, the slots that sound and fade
    assert callback.count("stlr") >= 6


def test_a_push_is_published_after_everything_else_is_written(tmp_path):
    push = instructions("push", tmp_path)
    assert push.count("stlr") == 1
    room = next(i for i, one in enumerate(push) if one in ("ldar", "ldapr"))
    between = push[room : push.index("stlr")]
    # its time, its angle, whether it touches
    assert sum({"str": 1, "stur": 1, "stp": 2}.get(one, 0) for one in between) >= 3


def test_no_published_column_is_written_plainly():
    package = Path(overview_dsp.__file__).parent
    for path in [*(package / "kernels").rglob("*.py"), package / "engine" / "queues.py"]:
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
