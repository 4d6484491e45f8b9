"""Compiled kernels: pure functions on flat arrays. Only this package imports numba.

Importing this package imports numba (about 0.3 s); importing `overview_dsp` does not.
Every kernel uses a portable subset of Python, so that the same source runs as numba machine
code, as plain Python (`NUMBA_DISABLE_JIT=1`), as PortAudio's native callback and as WebAssembly,
with the same bits: flat one-dimensional arrays, own math functions, no allocation, no
exceptions, no globals that change, no fused or reordered arithmetic.

`block.py` processes one voice, `simd/block.py` several voices in the lanes of vectors. The units
accept numbers and the lanes of `simd/vector.py` alike.
"""
