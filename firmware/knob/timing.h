/* When a motor knob's board steps, reports and ends its torque, from a counter of microseconds that
begins again after 71.6 minutes: times are only subtracted, so that it may.

One file for boards and tests, C99 and C++. Include surface.h before it.

    static KnobClock clock;
    knob_clock_begin(&clock, micros());
    for (;;) {
        if (...a frame came...) knob_clock_heard(&clock, micros());
        count = knob_clock_due(&clock, micros());    // steps to take now
        ... clock.alive ? torque : 0 ...
    }

After a delay, the steps that are due are taken at once, up to KNOB_CATCH_UP of them. More than that
are a stall: they are left out and counted. */
#ifndef KNOB_TIMING_H
#define KNOB_TIMING_H

#include <stdint.h>

#if 1000000 % KNOB_HZ
#error "KNOB_HZ must be a whole part of 1000000, such as 1000, 2000, 2500 or 4000"
#endif

#define KNOB_STEP_US (1000000 / KNOB_HZ)
#define KNOB_CATCH_UP (KNOB_HZ / 250) /* steps: 4 ms */
#define KNOB_DEAD_US 38000u           /* without a frame: with one slow pass, 40 ms */
#define KNOB_TELL_US 2000u

typedef struct {
    uint32_t last;     /* when the latest step was due, us */
    uint32_t heard;    /* when the latest frame came, us */
    uint32_t told;     /* when the latest report was due, us */
    uint32_t left_out; /* steps */
    uint8_t alive;     /* a frame came, and none was late since: only a new frame sets it again */
    uint8_t stalled;   /* the latest pass left steps out */
} KnobClock;

static inline void knob_clock_begin(KnobClock *c, uint32_t now) {
    c->last = c->heard = c->told = now;
    c->left_out = 0;
    c->alive = c->stalled = 0;
}

static inline void knob_clock_heard(KnobClock *c, uint32_t now) {
    c->heard = now;
    c->alive = 1;
}

/* How many steps are due. Call it in every pass: a silence must be seen before the counter turns. */
static inline int knob_clock_due(KnobClock *c, uint32_t now) {
    uint32_t count = (uint32_t)(now - c->last) / KNOB_STEP_US;
    if (c->alive && (uint32_t)(now - c->heard) > KNOB_DEAD_US) c->alive = 0;
    c->last += count * KNOB_STEP_US;
    c->stalled = count > KNOB_CATCH_UP;
    if (c->stalled) {
        c->left_out += count - KNOB_CATCH_UP;
        count = KNOB_CATCH_UP;
    }
    return (int)count;
}

/* Is a report due? 500 a second; those missed in a stall are not sent later. */
static inline int knob_clock_tells(KnobClock *c, uint32_t now) {
    uint32_t late = now - c->told;
    if (late < KNOB_TELL_US) return 0;
    c->told = late > 2 * KNOB_TELL_US ? now : c->told + KNOB_TELL_US;
    return 1;
}

#endif
