"""The compiled half: pure functions on flat arrays, the only place that imports numba.

Importing this package imports numba (about 0.3 s); importing `overview_dsp` does not.
Every kernel is written in the portable subset, so that the same source runs as numba machine
code, as plain Python (`NUMBA_DISABLE_JIT=1`), as PortAudio's native callback and as WebAssembly,
with the same bits: flat one-dimensional arrays, own elementary functions, no allocation, no
exceptions, no globals that change, no fused or reordered arithmetic.

`block.py` drives a voice, `lane_block.py` several side by side: what a unit does to a number it
does to the numbers of `lanes.py` too, which are one of each voice.
"""
