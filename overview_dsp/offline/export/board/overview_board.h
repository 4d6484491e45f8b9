/* A timeline that a board plays alone: the disk, its clicks and its vibration in single precision.

    #include "overview_board.h"
    #include "timeline.h"                                  // written by `overview export --to board`

    static OverviewBoard voice;                            // 4 kB; several voices may share a timeline
    overview_board_init(&voice, &OVERVIEW_TIMELINE);
    for (;;) {                                             // at OVERVIEW_SAMPLE_RATE
        overview_board_set(&voice, theta2, touching);      // rad, 0 to pi; any number of times
        overview_board_process(&voice, click, tactor, n);  // n samples each, -1 to 1
    }

One file for boards, emulators and tests, C99 and C++: no libm, no allocation, no lock. Call `set` and
`process` from the same thread or interrupt; a position from elsewhere is handed over as one float.

It computes what `overview render` computes, stage by stage (overview_dsp/kernels: two_disk, clutch,
release, event_crossing, click, texture, envelope, tactor, limiter), with these differences:

- float instead of double. Positions are therefore whole cells of the table and a fraction, speeds
  are changed by differences, and the carrier's phase is an integer.
- A click ends at -100 dB instead of -160 dB.
- Parameters are fixed by the export. There is one input, and viscous friction only. */
#ifndef OVERVIEW_BOARD_H
#define OVERVIEW_BOARD_H

#include <stdint.h>
#include <string.h>

#ifndef OVERVIEW_FLASH /* of large tables; without it, a Teensy 4 would copy them to its RAM */
#if defined(__IMXRT1062__) && defined(PROGMEM)
#define OVERVIEW_FLASH PROGMEM
#else
#define OVERVIEW_FLASH
#endif
#endif

/* Called at each strike: the number of the event in the comment of timeline.h (-1: the surface), and
its level, 0 to 1. Define it before including this file, such as to light a lamp at a goal. */
#ifndef OVERVIEW_STRUCK
#define OVERVIEW_STRUCK(voice, event, level) ((void)0)
#endif

enum {
    OVERVIEW_CELLS = 65536,  /* of the table: half a turn */
    OVERVIEW_MODES = 6,      /* of a kind, */
    OVERVIEW_BANKS = 33,     /* kinds of clicks, */
    OVERVIEW_PENDING = 16,   /* and strikes at a time: each takes 5 samples; more are counted as `lost` */
    OVERVIEW_EDGE_BITS = 14, /* of the fraction of an edge's position */
    OVERVIEW_GRID = 64       /* samples between two values of the output gain */
};

/* Coefficients, in the order of overview_dsp/kernels/layout.py, which has their units. */
enum {
    OV_SPRING_HELD, OV_SPRING_FREE, OV_INERTIA, OV_THETA, OV_OMEGA, OV_SMOOTH, OV_TORQUE, OV_GATE,
    OV_EXPONENT, OV_DECAY, OV_RISE, OV_CARRIER, OV_TACTOR_GAIN, OV_CLICK_GAIN, OV_STRIKE_TORQUE,
    OV_STRIKE_EXPONENT, OV_TEXTURE_GAIN, OV_TEXTURE_CUTOFF, OV_CEILING, OV_DC_POLE, OV_TEXTURE_LEVEL,
    OV_FORGET, OV_SPEED_RATIO, OV_REACH, OV_TAP_RATE, OV_LAG_RATE, OV_WINDUP, OV_MAX_SPEED, OV_BACKLASH,
    OV_PACE, OV_PACE_LEAST, OV_PACE_MOST, OV_SLOW_EXPONENT, OV_RECOIL_EXPONENT, OV_COEFFICIENTS
};

typedef struct { /* where an event is struck; in ascending order */
    int32_t at;  /* cells * 2**OVERVIEW_EDGE_BITS */
    uint16_t event;
} OverviewEdge;

typedef struct {
    float release; /* friction released there, N m s/rad */
    int32_t number; /* in the comment of timeline.h, -1 = the surface */
    uint8_t kind;
} OverviewEvent;

typedef struct {
    float re, im; /* rotation and decay in a sample */
    float turns, decay, gain;
} OverviewMode;

typedef struct {
    int32_t count, ring; /* modes, and samples until they are silent */
} OverviewKind;

typedef struct { /* written by the export; read only */
    const float *coefficients;
    const float *friction; /* OVERVIEW_CELLS + 1 points, N m s/rad, */
    const uint8_t *steep;     /* and a bit for each 32 cells: 1 = a step may cross a steep edge there */
    const OverviewEdge *lower, *upper; /* entered upwards and downwards */
    const OverviewEvent *events;
    const OverviewMode *modes; /* OVERVIEW_MODES of each kind */
    const OverviewKind *kinds;
    int32_t count;    /* of events */
    uint32_t carrier; /* turns a sample, 2**32 */
    uint32_t arrival; /* samples that shaft 2 stays after a release at most */
    uint64_t seed;
    uint8_t returns; /* 1 = shaft 2 stays on release, and the input returns to 0 */
} OverviewTimeline;

typedef struct {
    int32_t cell;
    float part; /* 0 to 1 */
} OverviewPosition;

typedef struct { /* a strike that sounds: eight pulses, half a sample apart */
    uint8_t kind, number, late; /* samples so far; 1 = the second pulse falls into the next sample */
    float level, even_re[OVERVIEW_MODES], even_im[OVERVIEW_MODES]; /* a mode at the end of the sample */
    float odd_re[OVERVIEW_MODES], odd_im[OVERVIEW_MODES];
} OverviewStrike;

typedef struct {
    const OverviewTimeline *timeline;
    uint32_t clock, due;
    /* the disk */
    OverviewPosition x, input, target, y1, y2, above, below, arrival_above, arrival_below;
    float v, approach, pace, wound, slip, wanted;
    int32_t lower, upper; /* edges at or below the disk */
    uint8_t touching, engaged, waiting;
    /* the sound */
    float gain_from, gain_step, gain_to, texture_gain;
    float follower, e1, e2, tactor_in, tactor_out, level, texture, click_in, click_out;
    uint32_t phase;
    uint64_t noise;
    uint32_t strikes, lost;
    int32_t pending;
    OverviewStrike pulses[OVERVIEW_PENDING];
    int32_t ringing;
    uint8_t sounding[OVERVIEW_BANKS];
    int32_t left[OVERVIEW_BANKS];
    float re[OVERVIEW_BANKS][OVERVIEW_MODES], im[OVERVIEW_BANKS][OVERVIEW_MODES];
} OverviewBoard;

/* --- functions of numbers ----------------------------------------------------------------------- */

static inline float ov_abs(float x) { return x < 0.0f ? -x : x; }
static inline float ov_min(float a, float b) { return a < b ? a : b; }
static inline float ov_max(float a, float b) { return a > b ? a : b; }

static inline uint32_t ov_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline float ov_float(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The atanh series of the mantissa; x is normal and positive. */
static float ov_log2(float x) {
    const int32_t exponent = (int32_t)((ov_bits(x) + (0x3F800000u - 0x3F3504F3u)) >> 23) - 127;
    const float f = ov_float(ov_bits(x) - ((uint32_t)exponent << 23)), s = (f - 1.0f) / (f + 1.0f), t = s * s;
    return (float)exponent +
           2.88539008f * s * (1.0f + t * (0.333333333f + t * (0.2f + t * (0.142857143f + t * 0.111111111f))));
}

static float ov_exp2(float y) {
    int32_t whole;
    float z;
    y = ov_min(ov_max(y, -120.0f), 120.0f);
    whole = (int32_t)(y + 128.5f) - 128;
    z = (y - (float)whole) * 0.693147181f;
    z = 1.0f + z * (1.0f + z * (0.5f + z * (0.166666667f + z * (0.0416666667f + z * (0.00833333333f + z * 0.00138888889f)))));
    return z * ov_float((uint32_t)(whole + 127) << 23);
}

static float ov_power(float x, float p) { return ov_exp2(p * ov_log2(x)); }

/* Sine of a phase in units of 2**-32 turns. */
static float ov_sine(uint32_t phase) {
    float x, t;
    if ((phase + 0x40000000u) & 0x80000000u) phase = 0x80000000u - phase;
    x = (float)(int32_t)phase * 1.46291808e-9f;
    t = x * x;
    return x * (1.0f + t * (-0.166666667f + t * (8.33333333e-3f + t * (-1.98412698e-4f + t * (2.75573192e-6f - t * 2.50521084e-8f)))));
}

/* turns: 0 to 1 */
static uint32_t ov_phase(float turns) { return (uint32_t)(turns * 4294967296.0f); }

static float ov_root(float x) {
    float y;
    if (x < 1e-30f) return 0.0f;
    y = ov_float(0x5F375A86u - (ov_bits(x) >> 1));
    y *= 1.5f - 0.5f * x * y * y;
    y *= 1.5f - 0.5f * x * y * y;
    y *= 1.5f - 0.5f * x * y * y;
    return x * y;
}

/* --- positions and friction --------------------------------------------------------------------- */

static inline float ov_between(OverviewPosition a, OverviewPosition b) {
    return (float)(a.cell - b.cell) + (a.part - b.part);
}

static inline OverviewPosition ov_moved(OverviewPosition from, float by) {
    const float part = from.part + by;
    int32_t whole = (int32_t)part;
    if (part < (float)whole) whole--;
    from.cell += whole;
    from.part = part - (float)whole;
    return from;
}

static inline OverviewPosition ov_place(int32_t cell) {
    OverviewPosition position;
    position.cell = cell;
    position.part = 0.0f;
    return position;
}

static inline OverviewPosition ov_edge(const OverviewEdge *edge) {
    OverviewPosition position = ov_place(edge->at >> OVERVIEW_EDGE_BITS);
    position.part = (float)(edge->at & ((1 << OVERVIEW_EDGE_BITS) - 1)) * (1.0f / (1 << OVERVIEW_EDGE_BITS));
    return position;
}

static float ov_friction(const OverviewTimeline *t, OverviewPosition at) {
    const float *points;
    if (at.cell < 0) at = ov_place(0);
    if (at.cell >= OVERVIEW_CELLS) at.cell = OVERVIEW_CELLS - 1, at.part = 1.0f;
    points = t->friction + at.cell;
    return points[0] + (points[1] - points[0]) * at.part;
}

static int ov_steep(const OverviewTimeline *t, OverviewPosition at) {
    const int32_t cell = at.cell < 0 ? 0 : at.cell > OVERVIEW_CELLS ? OVERVIEW_CELLS : at.cell;
    return t->steep[cell >> 8] >> (cell >> 5 & 7) & 1;
}

/* The integral of the friction along a way from x, cell by cell. */
static float ov_taken(const OverviewTimeline *t, OverviewPosition x, float way) {
    const OverviewPosition to = ov_moved(x, way), low = way < 0.0f ? to : x, high = way < 0.0f ? x : to;
    float before = ov_friction(t, low), after = ov_friction(t, high), sum, next;
    int32_t cell;
    if (low.cell == high.cell) return way * 0.5f * (before + after);
    next = ov_friction(t, ov_place(low.cell + 1));
    sum = (1.0f - low.part) * (before + next);
    for (cell = low.cell + 1; cell < high.cell; cell++) {
        before = next;
        next = ov_friction(t, ov_place(cell + 1));
        sum += before + next;
    }
    sum = 0.5f * (sum + high.part * (next + after));
    return way < 0.0f ? -sum : sum;
}

/* --- events ------------------------------------------------------------------------------------- */

#define OV_FAR (1 << 29)         /* cells: beyond any position */
#define OV_RETREAT 1e-6f         /* cells: hysteresis before an edge counts as passed again */
#define OV_NEAR (0.006f * OVERVIEW_CELLS) /* cells: a disk this close to its target has arrived */

static OverviewPosition ov_above(const OverviewTimeline *t, const OverviewEdge *edges, int32_t number) {
    return number < t->count ? ov_edge(edges + number) : ov_place(OV_FAR);
}

static OverviewPosition ov_below(const OverviewEdge *edges, int32_t number) {
    return number > 0 ? ov_moved(ov_edge(edges + number - 1), -OV_RETREAT) : ov_place(-OV_FAR);
}

static inline OverviewPosition ov_lowest(OverviewPosition a, OverviewPosition b) {
    return ov_between(a, b) < 0.0f ? a : b;
}

static inline OverviewPosition ov_highest(OverviewPosition a, OverviewPosition b) {
    return ov_between(a, b) < 0.0f ? b : a;
}

/* Where the disk next passes an edge, or arrives after a release. */
static void ov_look(OverviewBoard *v) {
    const OverviewTimeline *t = v->timeline;
    v->above = ov_lowest(ov_above(t, t->lower, v->lower), ov_above(t, t->upper, v->upper));
    v->above = ov_lowest(v->above, v->arrival_above);
    v->below = ov_highest(ov_below(t->lower, v->lower), ov_below(t->upper, v->upper));
    v->below = ov_highest(v->below, v->arrival_below);
}

static int32_t ov_count_below(const OverviewTimeline *t, const OverviewEdge *edges, OverviewPosition at) {
    int32_t low = 0, high = t->count;
    while (low < high) {
        const int32_t middle = (low + high) / 2;
        if (ov_between(ov_edge(edges + middle), at) <= 0.0f) low = middle + 1;
        else high = middle;
    }
    return low;
}

static void ov_strike(OverviewBoard *v, int32_t event, float fraction) {
    const OverviewTimeline *t = v->timeline;
    const float *c = t->coefficients;
    const OverviewEvent *struck = t->events + event;
    const OverviewKind *kind = t->kinds + struck->kind;
    const float hardness = struck->release * v->approach * c[OV_STRIKE_TORQUE];
    float level = 0.0f, even = 1.0f - fraction, odd = 0.5f - fraction;
    OverviewStrike *strike;
    int32_t n;
    if (hardness > 1e-12f) {
        level = ov_power(hardness, c[OV_STRIKE_EXPONENT]);
        level = level / (1.0f + level);
    }
    v->strikes++;
    OVERVIEW_STRUCK(v, struck->number, level);
    if (!kind->count) return;
    if (v->pending == OVERVIEW_PENDING) {
        v->lost++;
        return;
    }
    strike = v->pulses + v->pending++;
    strike->kind = struck->kind;
    strike->number = 0;
    strike->late = odd < 0.0f;
    if (strike->late) odd += 1.0f;
    strike->level = level;
    for (n = 0; n < kind->count; n++) {
        const OverviewMode *mode = t->modes + struck->kind * OVERVIEW_MODES + n;
        float size = mode->gain * ov_exp2(mode->decay * 1.44269504f * even);
        uint32_t phase = ov_phase(mode->turns * even);
        strike->even_re[n] = size * ov_sine(phase + 0x40000000u);
        strike->even_im[n] = size * ov_sine(phase);
        size = mode->gain * ov_exp2(mode->decay * 1.44269504f * odd);
        phase = ov_phase(mode->turns * odd);
        strike->odd_re[n] = size * ov_sine(phase + 0x40000000u);
        strike->odd_im[n] = size * ov_sine(phase);
    }
}

static void ov_pass(OverviewBoard *v, OverviewPosition was) {
    const OverviewTimeline *t = v->timeline;
    const OverviewPosition x = v->x;
    OverviewPosition edge;
    while (edge = ov_above(t, t->lower, v->lower), ov_between(x, edge) >= 0.0f) {
        ov_strike(v, t->lower[v->lower].event, ov_between(edge, was) / ov_between(x, was));
        v->lower++;
    }
    while (ov_between(x, ov_below(t->lower, v->lower)) < 0.0f) v->lower--;
    while (ov_between(x, ov_above(t, t->upper, v->upper)) >= 0.0f) v->upper++;
    while (edge = ov_below(t->upper, v->upper), ov_between(x, edge) < 0.0f) {
        v->upper--;
        ov_strike(v, t->upper[v->upper].event,
                  ov_between(was, edge) > 0.0f ? ov_between(was, edge) / ov_between(was, x) : 0.0f);
    }
}

/* --- touch and release -------------------------------------------------------------------------- */

static void ov_stop_waiting(OverviewBoard *v) {
    v->waiting = 0;
    v->arrival_above = ov_place(OV_FAR);
    v->arrival_below = ov_place(-OV_FAR);
}

static void ov_start_pace(OverviewBoard *v) {
    v->pace = v->wanted = v->timeline->coefficients[OV_TAP_RATE] * OVERVIEW_CELLS;
}

static int ov_has_arrived(const OverviewBoard *v) {
    return ov_between(v->x, v->arrival_above) >= 0.0f || ov_between(v->x, v->arrival_below) < 0.0f;
}

static void ov_arrive(OverviewBoard *v) {
    ov_stop_waiting(v);
    if (v->timeline->returns) {
        v->input = ov_place(0);
        ov_start_pace(v);
    } else {
        v->engaged = 0;
    }
}

/* Shaft 2 stays until the disk is near the target, past all events before it. */
static void ov_wait(OverviewBoard *v) {
    const OverviewTimeline *t = v->timeline;
    const OverviewPosition target = v->input;
    const int32_t lower = ov_count_below(t, t->lower, target), upper = ov_count_below(t, t->upper, target);
    v->waiting = 1;
    v->due = v->clock + t->arrival;
    if (ov_between(v->x, target) < 0.0f) {
        v->arrival_above = ov_moved(target, -OV_NEAR);
        if (lower) v->arrival_above = ov_highest(v->arrival_above, ov_edge(t->lower + lower - 1));
        if (upper) v->arrival_above = ov_highest(v->arrival_above, ov_edge(t->upper + upper - 1));
    } else {
        v->arrival_below = ov_lowest(ov_above(t, t->lower, lower), ov_above(t, t->upper, upper));
        v->arrival_below = ov_lowest(ov_moved(target, OV_NEAR), v->arrival_below);
    }
    if (ov_has_arrived(v)) ov_arrive(v);
}

/* Start at rest at the beginning of the timeline. */
static inline void overview_board_init(OverviewBoard *v, const OverviewTimeline *timeline) {
    memset(v, 0, sizeof *v);
    v->timeline = timeline;
    v->gain_from = v->gain_to = v->texture_gain = 1.0f;
    v->noise = timeline->seed;
    ov_stop_waiting(v);
    v->lower = ov_count_below(timeline, timeline->lower, v->x);
    v->upper = ov_count_below(timeline, timeline->upper, v->x);
    ov_look(v);
}

/* Set the input's angle (rad, 0 to pi: the whole timeline) and whether it touches, from the next
sample on. On release, the disk still moves to the last angle, then it recoils. */
static inline void overview_board_set(OverviewBoard *v, float theta2, int touching) {
    const float *c = v->timeline->coefficients;
    OverviewPosition at;
    at = v->target; /* the last angle, if this one isn't a finite number */
    if (theta2 - theta2 == 0.0f)
        at = ov_moved(ov_place(0), ov_min(ov_max(theta2 * 20860.7567f, 0.0f), (float)OVERVIEW_CELLS));
    if (touching && !v->touching) {
        v->input = v->target = v->y1 = v->y2 = at;
        v->wound = v->slip = 0.0f;
        v->engaged = 1;
        ov_start_pace(v);
        ov_stop_waiting(v);
    } else if (touching) {
        const float from_start = ov_between(at, ov_place(0)), room = ov_min(from_start, OVERVIEW_CELLS - from_start);
        const float play = ov_min(c[OV_BACKLASH], room), way = ov_between(at, v->input);
        if (way > play) v->input = ov_moved(at, -play);
        if (way < -play) v->input = ov_moved(at, play);
        v->target = at;
    } else if (v->touching) {
        v->input = v->target;
        ov_wait(v);
    }
    v->touching = touching != 0;
    ov_look(v);
}

/* --- one sample --------------------------------------------------------------------------------- */

/* Limit the stretch of shaft 2, which is `rigid` (cells) without a clutch. */
static float ov_clutched(OverviewBoard *v, float rigid, float friction, int moves) {
    const float *c = v->timeline->coefficients;
    const float room = friction * c[OV_REACH] + 0.5f, load = v->wanted * room;
    const float growth = c[OV_WINDUP] * ov_min(v->pace, c[OV_MAX_SPEED]), way = ov_abs(rigid);
    const float high = ov_min(load, ov_max(v->wound, 0.0f) + growth);
    const float low = ov_max(-load, ov_min(v->wound, 0.0f) - growth);
    const float stretch = ov_min(ov_max(rigid, low), high);
    const float faster = v->pace + ov_max(0.0f, way - room * v->pace) * c[OV_LAG_RATE];
    v->slip = rigid - stretch;
    v->wanted = ov_min(ov_max(ov_min(c[OV_SPEED_RATIO] * v->pace, faster), way * c[OV_TAP_RATE]), c[OV_MAX_SPEED]);
    if (!moves) { /* towards a resting input, no faster than friction alone can stop */
        const float stopping = 3.2f * (way * friction / c[OV_INERTIA]) - 3.0f * ov_abs(v->v);
        v->wanted = ov_min(v->wanted, ov_max(stopping, 1e-9f));
    }
    return stretch;
}

/* Move the disk by a sample; return its mean speed omega1 (rad/s) and set the friction it met. */
static float ov_move(OverviewBoard *v, float *met) {
    const OverviewTimeline *t = v->timeline;
    const float *c = t->coefficients;
    const float spring = v->engaged ? c[OV_SPRING_HELD] : c[OV_SPRING_FREE], inertia = c[OV_INERTIA];
    const float denominator = inertia * (2.0f + 0.5f * spring), speed = v->v;
    const OverviewPosition was = v->x, midpoint = ov_moved(was, 0.5f * speed);
    const int slips = v->engaged && c[OV_REACH] < 1e30f;
    float friction = ov_friction(t, midpoint), moved, stretch, change, middle, omega;
    int moves, n;
    v->y1 = ov_moved(v->y1, c[OV_SMOOTH] * ov_between(v->input, v->y1));
    moved = c[OV_SMOOTH] * ov_between(v->y1, v->y2);
    v->y2 = ov_moved(v->y2, moved);
    moved = ov_abs(moved);
    moves = moved > c[OV_PACE_LEAST] && moved < c[OV_PACE_MOST];
    if (!slips) v->slip = v->wanted = 0.0f;
    if (moves && v->touching && (moved > v->pace || v->slip == 0.0f)) v->pace += c[OV_PACE] * (moved - v->pace);
    stretch = ov_between(v->engaged ? v->y2 : ov_place(0), was);
    if (slips) stretch = ov_clutched(v, stretch, friction, moves);
    v->wound = stretch;
    /* the midpoint speed, as the change of the speed: float would lose its last digits */
    change = (inertia * spring * (stretch - 0.5f * speed) - friction * speed) / (denominator + friction);
    middle = speed + change;
    if (ov_steep(t, midpoint)) { /* the friction is its mean over the way: Newton's method */
        const float push = inertia * (2.0f * speed + spring * stretch);
        for (n = 0; n < 2; n++) {
            const float taken = ov_taken(t, was, middle), there = ov_friction(t, ov_moved(was, middle));
            middle -= (middle * denominator + taken - push) / (denominator + there);
        }
        if (ov_abs(middle) > 1.0f / 64.0f) friction = ov_taken(t, was, middle) / middle;
        else friction = ov_friction(t, ov_moved(was, 0.5f * middle));
        change = (inertia * spring * (stretch - 0.5f * speed) - friction * speed) / (denominator + friction);
        middle = speed + change;
    }
    v->x = ov_moved(was, middle);
    v->v = speed + 2.0f * change;
    omega = middle * c[OV_OMEGA];
    v->approach = ov_max(ov_abs(omega), v->approach * c[OV_FORGET]);
    if (ov_abs(v->v) < 1e-18f) v->v = 0.0f; /* smaller numbers would slow some processors down */
    if (v->x.part < 1e-18f) v->x.part = 0.0f;
    if (v->approach < 1e-18f) v->approach = 0.0f;
    if (ov_between(v->x, v->above) >= 0.0f || ov_between(v->x, v->below) < 0.0f) {
        ov_pass(v, was);
        if (ov_has_arrived(v)) ov_arrive(v);
        ov_look(v);
    }
    *met = friction;
    return omega;
}

/* Output gains of slow inputs and of the recoil: see overview_dsp/kernels/output_gain.py. */
static void ov_set_gain(OverviewBoard *v) {
    const float *c = v->timeline->coefficients;
    const float before = v->gain_to;
    v->texture_gain = v->gain_to = 1.0f;
    if (c[OV_SLOW_EXPONENT] > 0.0f || c[OV_RECOIL_EXPONENT] > 0.0f) {
        if (v->engaged) { /* 0.4 over the pace, which counts from 0.02 timelines a second on */
            const float pace = ov_min(ov_max(v->pace / c[OV_PACE_LEAST] * 0.02f, 0.02f), 0.4f);
            v->gain_to = ov_power(0.4f / pace, c[OV_SLOW_EXPONENT]);
            v->texture_gain = v->gain_to * v->gain_to;
        } else {
            const float cursor = ov_between(v->x, ov_place(0)) * (1.0f / OVERVIEW_CELLS);
            v->gain_to = ov_power(1.0f / ov_min(ov_max(cursor, 0.02f), 1.0f), c[OV_RECOIL_EXPONENT]);
            v->texture_gain = ov_root(v->gain_to);
        }
    }
    v->gain_from = before;
    v->gain_step = (v->gain_to - before) * (1.0f / OVERVIEW_GRID);
}

/* Add the pulses of a strike in this sample to its modes; return whether more follow. */
static int ov_pulse(OverviewBoard *v, OverviewStrike *strike) {
    static const float WEIGHT[8] = {/* sin(pi (n + 1/2)/8)**2 / 4 */
        0.00951505829f, 0.0771645710f, 0.172835429f, 0.240484942f,
        0.240484942f, 0.172835429f, 0.0771645710f, 0.00951505829f};
    const OverviewKind *kind = v->timeline->kinds + strike->kind;
    const int n = strike->number++, late = n - strike->late;
    const float even = n < 4 ? strike->level * WEIGHT[2 * n] : 0.0f;
    const float odd = late >= 0 && late < 4 ? strike->level * WEIGHT[2 * late + 1] : 0.0f;
    float *re = v->re[strike->kind], *im = v->im[strike->kind];
    int j;
    if (!v->left[strike->kind]) v->sounding[v->ringing++] = strike->kind;
    v->left[strike->kind] = kind->ring;
    for (j = 0; j < kind->count; j++) {
        re[j] += even * strike->even_re[j] + odd * strike->odd_re[j];
        im[j] += even * strike->even_im[j] + odd * strike->odd_im[j];
    }
    return strike->number < 4 + strike->late;
}

/* One sample of all ringing modes. */
static float ov_ring(OverviewBoard *v) {
    float total = 0.0f;
    int32_t i = 0, j;
    while (i < v->pending) {
        if (ov_pulse(v, v->pulses + i)) i++;
        else v->pulses[i] = v->pulses[--v->pending];
    }
    for (i = 0; i < v->ringing;) {
        const int kind = v->sounding[i], count = v->timeline->kinds[kind].count;
        const OverviewMode *mode = v->timeline->modes + kind * OVERVIEW_MODES;
        float *re = v->re[kind], *im = v->im[kind];
        for (j = 0; j < count; j++, mode++) {
            const float x = re[j], y = im[j];
            total += y;
            re[j] = mode->re * x - mode->im * y;
            im[j] = mode->im * x + mode->re * y;
        }
        if (--v->left[kind]) {
            i++;
        } else {
            memset(re, 0, sizeof v->re[kind]);
            memset(im, 0, sizeof v->im[kind]);
            v->sounding[i] = v->sounding[--v->ringing];
        }
    }
    return total;
}

/* The amplitude of a torque, 0 to 1. */
static float ov_compress(const float *c, float torque) {
    const float t = ov_abs(torque) * c[OV_TORQUE] - c[OV_GATE];
    float a, squared;
    if (!(t > 1e-12f)) return 0.0f;
    a = ov_min(ov_power(t, c[OV_EXPONENT]), 3.0f);
    squared = a * a;
    return a * (27.0f + squared) / (27.0f + 9.0f * squared);
}

static float ov_envelope(OverviewBoard *v, float amplitude) {
    const float *c = v->timeline->coefficients;
    if (amplitude > v->follower) v->follower = amplitude;
    else v->follower += c[OV_DECAY] * (amplitude - v->follower);
    if (amplitude == 0.0f && v->follower < 1e-7f) v->follower = 0.0f;
    v->e1 += c[OV_RISE] * (v->follower - v->e1);
    v->e2 += c[OV_RISE] * (v->e1 - v->e2);
    if (v->follower == 0.0f && v->e1 + v->e2 < 1e-7f) v->e1 = v->e2 = 0.0f;
    return v->e2;
}

/* Noise whose level follows the power of friction, brighter with speed. */
static float ov_texture(OverviewBoard *v, float torque, float omega) {
    const float *c = v->timeline->coefficients;
    const float target = c[OV_TEXTURE_GAIN] * v->texture_gain * ov_root(ov_abs(torque * omega));
    const float bright = c[OV_TEXTURE_CUTOFF] * (ov_abs(omega) + 0.05f);
    float rough = 0.0f;
    v->level += c[OV_TEXTURE_LEVEL] * (target - v->level);
    if (target < 1e-5f && v->level <= 1e-5f) v->level = 0.0f;
    if (v->level > 0.0f) { /* xorshift64* */
        v->noise ^= v->noise >> 12;
        v->noise ^= v->noise << 25;
        v->noise ^= v->noise >> 27;
        rough = v->level * ((float)(uint32_t)(v->noise * UINT64_C(2685821657736338717) >> 40) * 1.1920929e-7f - 1.0f);
    }
    v->texture += (rough - v->texture) * (bright / (1.0f + bright));
    if (rough == 0.0f && ov_abs(v->texture) < 1e-5f) v->texture = 0.0f;
    return v->texture;
}

static float ov_block_dc(float x, float before, float y, float pole) {
    y = x - before + pole * y;
    return x == 0.0f && ov_abs(y) < 1e-9f ? 0.0f : y;
}

static float ov_limit(float x, float ceiling) {
    const float knee = 0.5f * ceiling, headroom = 0.999999f * ceiling - knee;
    float y;
    if (ov_abs(x) <= knee) return x;
    y = 1.0f - 2.0f / (ov_exp2(2.88539008f / headroom * (ov_abs(x) - knee)) + 1.0f);
    y = knee + headroom * y;
    return x > 0.0f ? y : -y;
}

/* Compute the next n samples of both signals; any n gives the same samples. */
static inline void overview_board_process(OverviewBoard *v, float *click, float *tactor, int n) {
    const OverviewTimeline *t = v->timeline;
    const float *c = t->coefficients;
    int i;
    for (i = 0; i < n; i++) {
        float friction, omega, torque, raised, wave, clicks;
        if (v->waiting && v->due == v->clock) {
            ov_arrive(v);
            ov_look(v);
        }
        if (v->clock % OVERVIEW_GRID == 0) ov_set_gain(v);
        omega = ov_move(v, &friction);
        torque = friction * omega;
        v->phase += t->carrier;
        raised = v->gain_from + v->gain_step * (float)(v->clock % OVERVIEW_GRID + 1);
        wave = ov_envelope(v, ov_compress(c, torque * raised)) * c[OV_TACTOR_GAIN] * ov_sine(v->phase);
        v->tactor_out = ov_block_dc(wave, v->tactor_in, v->tactor_out, c[OV_DC_POLE]);
        v->tactor_in = wave;
        clicks = (ov_texture(v, torque, omega) + ov_ring(v)) * c[OV_CLICK_GAIN];
        v->click_out = ov_block_dc(clicks, v->click_in, v->click_out, c[OV_DC_POLE]);
        v->click_in = clicks;
        click[i] = ov_limit(v->click_out, c[OV_CEILING]);
        tactor[i] = ov_limit(v->tactor_out, c[OV_CEILING]);
        v->clock++;
    }
}

#ifdef KNOB_SURFACE_H
/* Give the core of a motor knob (surface.h, included before this file) the frames that a host would
send: its disk, table and events. Each has its length before it. */
static inline void overview_board_knob(Knob *knob, const uint8_t *frames, int32_t count) {
    int32_t at;
    for (at = 0; at < count; at += 1 + frames[at]) knob_take(knob, frames + at + 1, frames[at]);
}
#endif

#endif
