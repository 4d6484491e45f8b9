"""The browser's kernel outside a browser."""

from __future__ import annotations

from importlib import resources
from typing import Any

import numpy as np
import pytest

from overview_dsp.kernels import layout

PAGE_BYTES = 65_536


class WasmKernel:
    """An instance of `kernel.wasm` with a memory block, run in blocks of any size."""

    def __init__(self, memory: np.ndarray, largest_block: int) -> None:
        wasmtime: Any = pytest.importorskip(
            "wasmtime", reason="needs a WebAssembly runtime: pip install wasmtime"
        )
        self._store = wasmtime.Store()
        source = resources.files("overview_dsp.web") / "kernel.wasm"
        module = wasmtime.Module(self._store.engine, source.read_bytes())
        exports = wasmtime.Instance(self._store, module, []).exports(self._store)
        self._render = exports["render"]
        self._memory = exports["memory"]
        heap = exports["__heap_base"].value(self._store)
        self._block = -(-heap // 8) * 8
        self._out = self._block + 8 * layout.TOTAL
        self._channels = int(memory.view(np.int64)[layout.L_CHANNELS])
        needed = self._out + 4 * largest_block * self._channels
        missing = needed - self._memory.data_len(self._store)
        self._memory.grow(self._store, -(-missing // PAGE_BYTES))
        self._memory.write(self._store, memory.tobytes(), self._block)

    def render(self, frames: int) -> np.ndarray:
        self.over = bool(self._render(self._store, self._out, frames, self._block))
        size = 4 * frames * self._channels
        data = self._memory.read(self._store, self._out, self._out + size)
        return np.frombuffer(bytes(data), np.float32).reshape(frames, self._channels)

    @property
    def memory(self) -> np.ndarray:
        data = self._memory.read(self._store, self._block, self._block + 8 * layout.TOTAL)
        return np.frombuffer(bytes(data))
