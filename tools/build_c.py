"""Build the kernel as C: `kernel.c` and `overview.h` in `overview_dsp/offline/export/c/`.

python tools/build_c.py [FOLDER]

numba's LLVM IR of `c_abi/c.py` is optimised for a processor without vector
registers, so that it has scalar operations only, and translated to C99 (ir_to_c.py). The same
tool-chain (named in kernel.c) gives the same bytes.
"""

from __future__ import annotations

import importlib.metadata
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import self_test
from ir_to_c import translated
from kernel_ir import ROOT, c_functions, machine_for, module_for, unoptimised, written_out

OUT = ROOT / "overview_dsp" / "offline" / "export" / "c"
SCALAR = {"cpu": "generic-rv64", "features": "+d"}

HEADER = """\
/* overView DSP: the voice in C. Made by tools/build_c.py; kernel.c is the other half.

   A voice is a memory of OVERVIEW_MEMORY_BYTES (8-byte aligned, initially zero) into which an image
   is loaded: a timeline and a preset from `overview export --to c`. The same events
   give the same samples as `ov.render`, bit for bit, for blocks of any size, at any sample rate.

   Nothing is allocated and nothing locked. overview_process belongs to the audio thread;
   overview_control and overview_change to one thread each. The others may be called only while no
   other function runs on that memory. With a compiler that has neither GCC's builtins nor
   <stdatomic.h>, on machines other than x86, one thread must call all of them. Little-endian
   machines only. */
#ifndef OVERVIEW_H
#define OVERVIEW_H
#include <stdint.h>
#include <string.h>
#ifdef __cplusplus
extern "C" {{
#endif

#define OVERVIEW_MEMORY_BYTES INT64_C({bytes})
#define OVERVIEW_DIGEST INT64_C({digest}) /* of the layout: an image begins with it */
#define OVERVIEW_AT_ONCE (-1)

enum {{ OVERVIEW_DONE = 0, OVERVIEW_REFUSED = -1, OVERVIEW_MISCOMPILED = -2 }};

/* A result in one line of English. */
const char *overview_message(int32_t result);

/* Sources of input. The last source to touch controls the disk. */
enum {{ {sources} }};

/* Parameters for overview_change, in the units of the table below. */
enum {{
{parameters}    OVERVIEW_PARAMETERS = {count}
}};
typedef struct {{
    const char *id, *unit; /* as in a preset's file; "" for a switch, 0 or 1 */
    double lowest, highest;
}} overview_parameter;
extern const overview_parameter overview_parameters[OVERVIEW_PARAMETERS];

/* Load an image of `bytes` bytes; call overview_prepare next. OVERVIEW_REFUSED if it is
   damaged, or of another layout: then the memory is all zero, or untouched. The first call in a
   process tests the machine code, in some 20 ms: OVERVIEW_MISCOMPILED if it would not give the
   bits of `ov.render`. From then on every function below returns that, too, and does nothing else,
   until the process ends. */
int32_t overview_load(void *memory, const void *image, int64_t bytes);

/* Reset at a sample rate in Hz: 1000 to 768000, and above the carrier's frequency / 0.45. */
int32_t overview_prepare(void *memory, double sample_rate);

/* Reset with the present parameters and drop pending events. */
int32_t overview_reset(void *memory);

/* Push an input's event: theta2 in rad (0 = start of the timeline, pi = its end), touching 0 or 1,
   at a sample since the last reset or OVERVIEW_AT_ONCE. OVERVIEW_REFUSED: {ring} are pending. */
int32_t overview_control(
    void *memory, int32_t source, int64_t sample_time, double theta2, int32_t touching);

/* Set a parameter, with 20 ms of smoothing. OVERVIEW_REFUSED: out of range, or too many are pending
   (it is then set with the next successful call). */
int32_t overview_change(void *memory, int32_t parameter, double value, int64_t sample_time);

/* Overwrite the next block: `frames` of `channels` interleaved floats; clicks on channel 0, the
   tactor on channel 1, the others silent. OVERVIEW_REFUSED with fewer than two channels. */
int32_t overview_process(void *memory, float *out, int64_t frames, int32_t channels);

/* Columns that can be read, as of the last block. */
enum {{
    OVERVIEW_PARAMETER = {params}, /* numbers: values of the parameters, in their order */
{meters}}};
static inline int64_t overview_count(const void *memory, int32_t column) {{
    int64_t x;
    memcpy(&x, (const char *)memory + 8 * column, 8);
    return x;
}}
static inline double overview_number(const void *memory, int32_t column) {{
    double x;
    memcpy(&x, (const char *)memory + 8 * column, 8);
    return x;
}}

#ifdef __cplusplus
}}
#endif
#endif
"""

KERNEL = """\
/* overView DSP: the voice in C, for overview.h. Made by tools/build_c.py from the Python kernels.
   kernels {digest}
   {toolchain} */
"""

TAIL = """
#include "overview.h"

const overview_parameter overview_parameters[OVERVIEW_PARAMETERS] = {{
{rows}}};

const char *overview_message(int32_t result) {{
    return result == OVERVIEW_DONE ? "done"
        : result == OVERVIEW_MISCOMPILED
            ? "kernel.c was compiled or linked with options that change its arithmetic: compile it "
              "without -ffast-math, its parts and -ffp-contract=fast"
        : "refused: the image is damaged or of another version, or a value is out of range";
}}

static const uint64_t ov_test_image[] = {{
{image}}};

static uint64_t ov_hashed(const unsigned char *memory, size_t first, size_t stop, uint64_t hash) {{
    for (; first < stop; first++)
        hash = (hash ^ ov_load_l(memory + 8 * first)) * UINT64_C({factor});
    return hash;
}}

/* Whether this machine code gives the bits of `ov.render` (tools/self_test.py). */
static int ov_is_right(unsigned char *memory) {{
    static const double hands[][3] = {{{hands}}};
    static const double changes[][3] = {{{changes}}};
    static const uint64_t models[] = {{{models}}};
    float out[{floats}];
    uint64_t hash = UINT64_C({seed});
    size_t i, n;
    if (ov_load(memory, (unsigned char *)ov_test_image, sizeof ov_test_image,
                (uint64_t)OVERVIEW_DIGEST)) return 0;
    for (i = 0; i < sizeof models / sizeof *models; i++) {{
        ov_store_l(memory + {models_at}, models[i]);
        ov_prepare(memory, {rate});
        for (n = 0; n < sizeof hands / sizeof *hands; n++)
            ov_control(memory, 0, (uint64_t)hands[n][0], hands[n][1], (uint32_t)hands[n][2]);
        for (n = 0; n < sizeof changes / sizeof *changes; n++)
            ov_change(memory, (uint32_t)changes[n][1], changes[n][2], (uint64_t)changes[n][0]);
        for (n = 0; n < {blocks} + {blocks_after_reset}; n++) {{
            if (n == {blocks}) {{
                ov_reset(memory);
                ov_control(memory, 0, 0, hands[0][1], (uint32_t)hands[0][2]);
            }}
            ov_process(memory, (unsigned char *)out, {block}, 2);
{hashes}        }}
    }}
    return hash == UINT64_C({expected});
}}

static int32_t ov_tested; /* 0: not yet, 1: right, OVERVIEW_MISCOMPILED: for good */
#define OV_REFUSE_IF_MISCOMPILED if (OV_GET(&ov_tested) < 0) return OVERVIEW_MISCOMPILED

int32_t overview_load(void *memory, const void *image, int64_t bytes) {{
    int32_t found = OV_GET(&ov_tested);
    if (!found) {{
        found = ov_is_right((unsigned char *)memory) ? 1 : OVERVIEW_MISCOMPILED;
        memset(memory, 0, (size_t)OVERVIEW_MEMORY_BYTES);
        OV_SET(&ov_tested, found);
    }}
    if (found < 0) return found;
    return (int32_t)ov_load((unsigned char *)memory, (unsigned char *)image, (uint64_t)bytes,
                            (uint64_t)OVERVIEW_DIGEST);
}}

int32_t overview_prepare(void *memory, double sample_rate) {{
    OV_REFUSE_IF_MISCOMPILED;
    return (int32_t)ov_prepare((unsigned char *)memory, sample_rate);
}}

int32_t overview_reset(void *memory) {{
    OV_REFUSE_IF_MISCOMPILED;
    return (int32_t)ov_reset((unsigned char *)memory);
}}

int32_t overview_control(
    void *memory, int32_t source, int64_t sample_time, double theta2, int32_t touching) {{
    OV_REFUSE_IF_MISCOMPILED;
    return (int32_t)ov_control((unsigned char *)memory, (uint32_t)source, (uint64_t)sample_time,
                               theta2, (uint32_t)touching);
}}

int32_t overview_change(void *memory, int32_t parameter, double value, int64_t sample_time) {{
    OV_REFUSE_IF_MISCOMPILED;
    if (parameter < 0 || parameter >= OVERVIEW_PARAMETERS
        || !(value >= overview_parameters[parameter].lowest
             && value <= overview_parameters[parameter].highest)) return OVERVIEW_REFUSED;
    return (int32_t)ov_change((unsigned char *)memory, (uint32_t)parameter, value,
                              (uint64_t)sample_time);
}}

int32_t overview_process(void *memory, float *out, int64_t frames, int32_t channels) {{
    OV_REFUSE_IF_MISCOMPILED;
    return (int32_t)ov_process((unsigned char *)memory, (unsigned char *)out, (uint64_t)frames,
                               (uint32_t)channels);
}}
"""


def main(folder: Path) -> None:
    with unoptimised():
        from c_abi.c import NAMES

        from overview_dsp.kernels.sources import sources_digest

        functions = c_functions(NAMES)
        machine = machine_for("riscv64-unknown-linux-gnu", **SCALAR)
        module = module_for(written_out(functions), machine)
        entries = {name: name.replace("overview_", "ov_") for name in NAMES}
        head = KERNEL.format(digest=sources_digest(), toolchain=toolchain())
        kernel = (
            head
            + translated(str(module), entries)
            + TAIL.format(rows=rows(), **test_numbers(functions))
        )
        header = HEADER.format(**header_numbers())
    for name, text in (("kernel.c", kernel), ("overview.h", header)):
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
        print(f"{folder / name}: {len(text)} bytes")


def toolchain() -> str:
    return ", ".join(f"{part} {importlib.metadata.version(part)}" for part in ("numba", "llvmlite"))


def rows() -> str:
    from overview_dsp.design.presets.parameters import PARAMETERS
    from overview_dsp.signal.engine.coefficients import KERNEL_RANGES

    return "".join(
        f'    {{"{id}", "{PARAMETERS[id].unit}", {low!r}, {high!r}}},\n'
        for id, (low, high) in KERNEL_RANGES.items()
    )


def test_numbers(functions: Mapping[str, Any]) -> dict[str, object]:
    """Return the image, the movements and the digest of the self-test as C."""
    from overview_dsp.kernels import layout

    image = self_test.image()
    words = [f"UINT64_C({word:#x})," for word in memoryview(image).cast("Q")]
    entries = {name: made.ctypes for name, made in functions.items()}
    return {
        "image": "".join(f"    {' '.join(words[i : i + 4])}\n" for i in range(0, len(words), 4)),
        "factor": self_test.FACTOR,
        "seed": self_test.SEED,
        "hands": ", ".join(f"{{{', '.join(map(repr, hand))}}}" for hand in self_test.HANDS),
        "changes": ", ".join(f"{{{', '.join(map(repr, one))}}}" for one in self_test.changes()),
        "models": ", ".join(map(str, self_test.MODELS)),
        "models_at": 8 * (layout.SURFACES + layout.SLOT_MODELS),
        "rate": self_test.RATE,
        "block": self_test.BLOCK,
        "blocks": self_test.BLOCKS,
        "blocks_after_reset": self_test.BLOCKS_AFTER_RESET,
        "floats": 2 * self_test.BLOCK,
        "hashes": "".join(
            f"            hash = ov_hashed(memory, {first}, {stop}, hash);\n"
            for first, stop in self_test.parts()
        ),
        "expected": self_test.digest(entries, image),
    }


def header_numbers() -> dict[str, object]:
    from overview_dsp.design.gestures import SOURCES
    from overview_dsp.kernels import layout
    from overview_dsp.offline.export.browser_memory import layout_digest
    from overview_dsp.signal.engine.coefficients import KERNEL_RANGES

    names = [id.upper().replace(".", "_") for id in KERNEL_RANGES]
    meters = [name for name in vars(layout) if name.startswith("M_")]
    return {
        "bytes": 8 * layout.TOTAL,
        "digest": int.from_bytes(layout_digest(), "little", signed=True),
        "sources": ", ".join(f"OVERVIEW_{name.upper()}" for name in SOURCES),
        "parameters": "".join(f"    OVERVIEW_{name},\n" for name in names),
        "count": len(names),
        "ring": layout.RING,
        "params": layout.PARAMS,
        "meters": f"    OVERVIEW_CLOCK = {layout.CLOCK}, /* count: samples since the reset */\n"
        + "".join(f"    OVERVIEW_{name} = {getattr(layout, name)},\n" for name in meters),
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT)
