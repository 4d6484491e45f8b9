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
extern "C" {
#endif

#define OVERVIEW_MEMORY_BYTES INT64_C(20589072)
#define OVERVIEW_DIGEST INT64_C(1124534665678118099) /* of the layout: an image begins with it */
#define OVERVIEW_AT_ONCE (-1)

enum { OVERVIEW_DONE = 0, OVERVIEW_REFUSED = -1, OVERVIEW_MISCOMPILED = -2 };

/* A result in one line of English. */
const char *overview_message(int32_t result);

/* Sources of input. The last source to touch controls the disk. */
enum { OVERVIEW_TOUCH, OVERVIEW_TWIST, OVERVIEW_SERIAL, OVERVIEW_OSC, OVERVIEW_MIDI, OVERVIEW_REMOTE };

/* Parameters for overview_change, in the units of the table below. */
enum {
    OVERVIEW_DISK_INERTIA,
    OVERVIEW_DISK_K1,
    OVERVIEW_DISK_K2,
    OVERVIEW_DISK_RELEASE,
    OVERVIEW_CLUTCH_MAX_SPEED_RATIO,
    OVERVIEW_CLUTCH_TAP_DURATION_S,
    OVERVIEW_CLUTCH_TIME_CONSTANT_S,
    OVERVIEW_CLUTCH_WINDUP_RATIO,
    OVERVIEW_CLUTCH_MAX_SPEED,
    OVERVIEW_CLUTCH_BACKLASH_PERCENT,
    OVERVIEW_INPUT_SMOOTHING_MS,
    OVERVIEW_TACTOR_REFERENCE_TORQUE_MNM,
    OVERVIEW_TACTOR_COMPRESSION,
    OVERVIEW_TACTOR_THRESHOLD_DB,
    OVERVIEW_TACTOR_RISE_MS,
    OVERVIEW_TACTOR_DECAY_MS,
    OVERVIEW_TACTOR_FREQUENCY_HZ,
    OVERVIEW_TACTOR_GAIN_DB,
    OVERVIEW_TACTOR_MUTE,
    OVERVIEW_TACTOR_SLOW_GAIN_EXPONENT,
    OVERVIEW_TACTOR_RECOIL_GAIN_EXPONENT,
    OVERVIEW_CLICK_REFERENCE_TORQUE_MNM,
    OVERVIEW_CLICK_COMPRESSION,
    OVERVIEW_CLICK_GAIN_DB,
    OVERVIEW_CLICK_MUTE,
    OVERVIEW_TEXTURE_GAIN_DB,
    OVERVIEW_TEXTURE_BRIGHTNESS_HZ,
    OVERVIEW_OUTPUT_CEILING_DB,
    OVERVIEW_PARAMETERS = 28
};
typedef struct {
    const char *id, *unit; /* as in a preset's file; "" for a switch, 0 or 1 */
    double lowest, highest;
} overview_parameter;
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
   at a sample since the last reset or OVERVIEW_AT_ONCE. OVERVIEW_REFUSED: 4096 are pending. */
int32_t overview_control(
    void *memory, int32_t source, int64_t sample_time, double theta2, int32_t touching);

/* Set a parameter, with 20 ms of smoothing. OVERVIEW_REFUSED: out of range, or too many are pending
   (it is then set with the next successful call). */
int32_t overview_change(void *memory, int32_t parameter, double value, int64_t sample_time);

/* Overwrite the next block: `frames` of `channels` interleaved floats; clicks on channel 0, the
   tactor on channel 1, the others silent. OVERVIEW_REFUSED with fewer than two channels. */
int32_t overview_process(void *memory, float *out, int64_t frames, int32_t channels);

/* Columns that can be read, as of the last block. */
enum {
    OVERVIEW_PARAMETER = 152, /* numbers: values of the parameters, in their order */
    OVERVIEW_CLOCK = 257, /* count: samples since the reset */
    OVERVIEW_M_BLOCKS = 5202,
    OVERVIEW_M_LATE = 5203,
    OVERVIEW_M_REJECTED = 5204,
    OVERVIEW_M_CLAMPED = 5205,
    OVERVIEW_M_RESETS = 5206,
    OVERVIEW_M_LIMITED = 5207,
    OVERVIEW_M_STRIKES = 5208,
    OVERVIEW_M_PEAK_CLICK = 5209,
    OVERVIEW_M_PEAK_TACTOR = 5210,
    OVERVIEW_M_TORQUE = 5211,
    OVERVIEW_M_ENVELOPE = 5212,
    OVERVIEW_M_FRICTION = 5213,
    OVERVIEW_M_SILENT = 5214,
    OVERVIEW_M_STILL = 5215,
    OVERVIEW_M_IMPULSE = 5216,
    OVERVIEW_M_SUMMED = 5217,
};
static inline int64_t overview_count(const void *memory, int32_t column) {
    int64_t x;
    memcpy(&x, (const char *)memory + 8 * column, 8);
    return x;
}
static inline double overview_number(const void *memory, int32_t column) {
    double x;
    memcpy(&x, (const char *)memory + 8 * column, 8);
    return x;
}

#ifdef __cplusplus
}
#endif
#endif
