/* The surface on a motor knob's own board: a disk, a brake, knocks and the serial protocol.

The host sends a friction table and a list of events once; from then on the board pulls a disk over
it with its own encoder's angle, so that the delay of the serial line doesn't matter to the feel. One
file for boards, emulators and tools: C99 and C++, float, no libm, no allocation. The same bytes and
angles give the same bits of torque wherever products and sums aren't contracted (-ffp-contract=off;
set below for GCC and clang).

    static Knob knob;
    knob_begin(&knob, angle);                    // rad, wherever the shaft is
    for (;;) {                                   // KNOB_HZ times a second
        while (...) knob_receive(&knob, byte);
        torque = knob_step(&knob, angle);        // N m along the angle, until the next step
        count = knob_report(&knob, microseconds, frame);    // 24 bytes to send, at 500 Hz
    }

The disk (x, in cells of the table; u the hand's angle in cells, e how far the spring between them
is stretched) is stepped by the implicit midpoint rule of overview_dsp/kernels/two_disk.py:

    vm = (J/dt) * (2*v + K*e) / ((J/dt) * (2 + K/2) + B),  x += vm,  v = 2*vm - v

The disk is virtual: its spring is STIFFER times that of the preset, and a clutch after that of
overview_dsp/kernels/clutch.py limits e. Neither takes energy from the hand or gives any to it,
because the hand only meets

    torque = pull - brush * brake

where the pull (to the start, and back from the two ends) depends on the hand's angle alone, and the
brake is the spring's torque where it opposes the hand, and the knocks of events. A knock begins
where the disk enters an event, lasts KNOCK_S, and is a parabola whose area is the event's push. The
brush, -1 to 1, bends with the hand: a hand that turns meets the whole brake, one that turns back
loses it within BRUSH_STEPS steps of the encoder, and one that rests is pushed no further than that.

Encoder and winding are late. Pull and brush therefore use the angle that the hand will have when
the torque acts, KNOB_LATE_S later. A value that is too small gives energy at the ends, one that is
too large costs nothing. */
#ifndef KNOB_SURFACE_H
#define KNOB_SURFACE_H

#include <stdint.h>
#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif

#ifndef KNOB_HZ
#define KNOB_HZ 4000 /* calls of knob_step a second, 1000 to 4000 */
#endif
#ifndef KNOB_POINTS
#define KNOB_POINTS 8193 /* of each of two tables, 2 bytes a point: 32 n + 1; 1025 are enough */
#endif
#ifndef KNOB_RESOLUTION
#define KNOB_RESOLUTION 3.835e-4f /* rad: a step of the encoder, here of 14 bits */
#endif
#ifndef KNOB_LATE_S
#define KNOB_LATE_S 0.0016f /* from an angle to its torque: encoder 0.3, winding 0.4, and a margin */
#endif

enum {
    KNOB_DISK = 16, KNOB_PART, KNOB_USE, KNOB_ALIVE, /* kinds of frames from the host, */
    KNOB_MOTION = 6, KNOB_STATE,                     /* and to it, as in devices/sensors/frames.py */
    KNOB_PART_POINTS = 32,
    KNOB_PARTS = (KNOB_POINTS - 1) / KNOB_PART_POINTS + 1,
    KNOB_PART_EVENTS = 10, /* in a part after those of the points */
    KNOB_ALL_PARTS = KNOB_PARTS + (KNOB_PARTS + KNOB_PART_EVENTS - 1) / KNOB_PART_EVENTS,
    KNOB_EVENTS = (KNOB_ALL_PARTS - KNOB_PARTS) * KNOB_PART_EVENTS,
    KNOB_LONGEST = 80,
    KNOB_MEAN = KNOB_HZ < 1000 ? 2 : KNOB_HZ / 500, /* steps of the mean speed: 2 ms */
    KNOB_HALF = KNOB_MEAN / 2,
    KNOB_SUBSTEPS = (4000 + KNOB_HZ - 1) / KNOB_HZ
};

#define KNOB_DT (1.0f / ((float)KNOB_HZ * (float)KNOB_SUBSTEPS))
#define KNOB_PER_RAD ((float)(KNOB_POINTS - 1) / 3.14159265f) /* cells */
#define KNOB_SILENT (KNOB_HZ * 28L / 1000) /* steps without a frame that end the torque */
#define KNOB_FALL (100.0f / KNOB_HZ) /* change of the level in one step: to 0 within 10 ms, */
#define KNOB_RISE (33.0f / KNOB_HZ)  /* to 1 within 30 ms, */
#define KNOB_HOME_RISE (2.0f / KNOB_HZ) /* and the pull to the start within 0.5 s */
#define KNOB_HOME 0.55f /* of the ceiling, most of the pull to the start, */
#define KNOB_PULL 0.8f  /* and of that and the ends together */
#define STIFFER 8.0f   /* spring of the disk, relative to the preset's */
#define CATCH_UP 2.0f  /* highest speed of the disk, relative to the hand's, */
#define CATCH_S 0.06f  /* and time in which it makes up for what friction didn't hold back */
#define CALM_S 0.01f   /* in which the disk slows down where the hand rests */
#define WIND 1.0f      /* growth of the stretch, relative to the hand's speed */
#define BRUSH_STEPS 1.5f
#define BRUSH_S 0.0005f /* low-pass of its angle: noise would unload it */
#define BRUSH_J 3e-5f    /* most of its brake times its width: a coarse encoder gets weaker knocks */
#define KNOCK_S 0.005f
#define KNOCK_SPEED 0.3f /* rad/s of theta2: a knock would push a hand slower than that */
#define KNOCK_AWAY 8 /* cells from an event at which it can knock again */
#define KNOCK_UNIT 1e-8f /* N m s */
#define TRAIL_S 0.02f    /* over which that speed is a mean, as a coarse encoder moves in jumps */
#define BRAKE_SPEED 8.0f /* rad/s of theta2, at which the brake is half as strong as at rest */
#define BRAKE_S 0.1f     /* in which the fastest speed is forgotten */
#define PACE_S 0.08f
#define PACE_LEAST 0.02f /* timelines a second, as in overview_dsp/kernels/derive.py */
#define PACE_MOST 6.0f

typedef struct { /* in a frame after the kind, an id and a flag: 1 = theta2 is 0 here */
    float inertia, k1, k2, unfold_s, smoothing_s; /* the preset's disk */
    float gain, knock, home;                      /* the scale of each torque */
    float ceiling;                                /* N m */
    float end;                                    /* N m/rad of theta2, beyond an end */
    float per_rad;                                /* theta2 for one rad of the shaft */
} KnobDisk;

typedef struct { /* sorted; push 0 ends the list */
    uint16_t first, last, push; /* cells, KNOCK_UNIT */
} KnobEvent;

typedef struct {
    /* from the host */
    KnobDisk disk;
    float unit[2]; /* N m s/rad that a 1 in the table stands for */
    uint16_t points[2][KNOB_POINTS];
    KnobEvent events[2][KNOB_EVENTS];
    uint8_t have[(KNOB_ALL_PARTS + 7) / 8];
    uint8_t disk_id, active_id, filling_id, slot, playing, changing;
    uint16_t missing; /* the first part not received yet */
    uint32_t silent;  /* steps since the last frame */
    uint16_t refused; /* frames with a wrong checksum */
    uint8_t frame[KNOB_LONGEST];
    uint8_t length;
    /* derived from it */
    float inertia, spring, denominator, hold, calm, unfold, smoothing, pacing, gain, home, end, sign;
    /* the knob and its disk */
    float origin, shaft, u, latest[KNOB_MEAN], ahead, brush, trail, fastest;
    float x, v, stretch, y1, y2, pace;
    float level, home_level, fade, fade_step, pull;
    float push, knocking, torque, used; /* the knock's push, N m s, and the part of it that is over */
    int cell;                           /* of the disk */
    uint8_t near_by[(KNOB_EVENTS + 7) / 8], slips, at;
    uint16_t sequence;
} Knob;

/* --- the disk --------------------------------------------------------------------------------- */

static float knob_abs(float x) { return x < 0.0f ? -x : x; }

static float knob_clamped(float x, float low, float high) {
    return x < low ? low : x > high ? high : x;
}

static float knob_friction_of(const Knob *k, int slot, float x) {
    const uint16_t *points = k->points[slot];
    float a, b;
    int i;
    x = x > 0.0f ? x : 0.0f; /* 0 for a NaN as well */
    x = x < (float)(KNOB_POINTS - 2) ? x : (float)(KNOB_POINTS - 2);
    i = (int)x;
    a = (float)points[i];
    b = (float)points[i + 1];
    return k->unit[slot] * (a + (b - a) * (x - (float)i));
}

static float knob_friction(const Knob *k, float x) {
    float friction = knob_friction_of(k, k->slot, x);
    if (k->fade > 0.0f)
        friction += (knob_friction_of(k, 1 - k->slot, x) - friction) * k->fade;
    return friction;
}

static int knob_cell(float x) { return x < 0.0f ? -1 : (int)x; }

/* Put the disk at the hand's angle, at rest, with the spring relaxed and without a knock. */
static void knob_rest(Knob *k) {
    k->x = k->ahead = k->trail = k->y1 = k->y2 = k->u;
    k->v = k->stretch = k->brush = k->fastest = k->push = k->torque = k->used = k->home_level = 0.0f;
    k->pace = k->unfold * (float)(KNOB_POINTS - 1);
    k->cell = knob_cell(k->x);
}

static void knob_derive(Knob *k) {
    const KnobDisk *d = &k->disk;
    float sum = d->k1 + d->k2, cell = 1.0f / KNOB_PER_RAD, theta1 = d->k2 / sum * cell, most;
    k->sign = d->per_rad < 0.0f ? -1.0f : 1.0f;
    k->inertia = d->inertia / KNOB_DT;
    k->spring = STIFFER * sum / d->inertia * KNOB_DT * KNOB_DT;
    k->denominator = k->inertia * (2.0f + 0.5f * k->spring);
    k->hold = 1.0f / (STIFFER * sum * KNOB_DT);
    k->calm = d->inertia / CALM_S;
    k->unfold = d->unfold_s > 0.0f ? KNOB_DT / d->unfold_s : PACE_MOST * KNOB_DT;
    k->smoothing = KNOB_DT / (d->smoothing_s + KNOB_DT);
    k->pacing = KNOB_DT / (PACE_S + KNOB_DT);
    k->gain = STIFFER * d->gain * d->k2 * theta1; /* N m per cell */
    k->home = d->home * d->gain * d->k1 * theta1; /* the same */
    most = KNOB_HOME * d->ceiling / (float)(KNOB_POINTS - 1);
    if (k->home > most) k->home = most;
    k->end = d->end * cell;                       /* the same */
}

/* Start the knocks of the events that the disk enters as it moves to another cell. */
static void knob_enter(Knob *k, int cell) {
    const KnobEvent *event = k->events[k->slot];
    int n;
    for (n = 0; n < KNOB_EVENTS && event->push; n++, event++) {
        const int first = event->first, last = event->last;
        uint8_t *near_by = &k->near_by[n / 8], bit = (uint8_t)(1 << n % 8);
        if (cell < first - KNOCK_AWAY || cell > last + KNOCK_AWAY) *near_by &= (uint8_t)~bit;
        if (!((k->cell < first && cell >= first) || (k->cell > last && cell <= last)) || *near_by & bit)
            continue;
        *near_by |= bit;
        if (k->push > k->disk.knock * KNOCK_UNIT * event->push) continue; /* the stronger one counts */
        k->push = k->disk.knock * KNOCK_UNIT * event->push;
        k->knocking = 0.0f;
    }
    k->cell = cell;
}

/* How far the spring is stretched, in cells, where a rigid shaft would be by `stretch`: what friction
at the allowed speed needs, and no more than the hand's speed has wound up. */
static float knob_stretched(Knob *k, float stretch, float friction) {
    const float size = knob_abs(stretch), hold = friction * k->hold;
    const float least = size * k->unfold, pace = k->pace > least ? k->pace : least;
    const float behind = size - hold * k->pace;
    float wanted = k->pace + (behind > 0.0f ? behind * (KNOB_DT / CATCH_S) : 0.0f), reach;
    if (wanted > CATCH_UP * k->pace) wanted = CATCH_UP * k->pace;
    if (wanted < least) wanted = least;
    reach = WIND * pace + (stretch * k->stretch > 0.0f ? knob_abs(k->stretch) : 0.0f);
    if (reach > wanted * hold) reach = wanted * hold;
    k->slips = size > reach;
    return knob_clamped(stretch, -reach, reach);
}

/* Step the disk, with the hand at `u` in the middle of the step; return the mean stretch. */
static float knob_move(Knob *k, float u) {
    const float cells = (KNOB_POINTS - 1) * KNOB_DT, least = PACE_LEAST * cells, y2 = k->y2;
    float moved, friction, middle;
    int cell;
    k->y1 += k->smoothing * (u - k->y1);
    k->y2 += k->smoothing * (k->y1 - k->y2);
    moved = knob_abs(k->y2 - y2);
    if (moved > least && moved < PACE_MOST * cells && (moved > k->pace || !k->slips))
        k->pace += k->pacing * (moved - k->pace);
    friction = knob_friction(k, k->x + 0.5f * k->v);
    /* a disk that still moves while the hand rests would swing about it */
    if (moved <= least && knob_abs(k->v) > least && friction < k->calm) friction = k->calm;
    k->stretch = knob_stretched(k, u - k->x, friction);
    middle = k->inertia * (2.0f * k->v + k->spring * k->stretch) / (k->denominator + friction);
    k->x += middle;
    k->v = 2.0f * middle - k->v;
    cell = knob_cell(k->x);
    if (cell != k->cell) knob_enter(k, cell);
    return k->stretch - 0.5f * middle;
}

/* The brake, N m, with `stretch` of the spring. */
static float knob_brake(Knob *k, float stretch) {
    const float left = k->disk.ceiling - knob_abs(k->pull);
    const float most = BRUSH_J / (BRUSH_STEPS * KNOB_RESOLUTION);
    const float room = left < most ? left : most, knee = 0.5f * room;
    const float step = 1.0f / (KNOCK_S * KNOB_HZ), slower = k->fastest / BRAKE_SPEED;
    float drag = k->brush * stretch > 0.0f ? k->gain * knob_abs(stretch) : 0.0f;
    if (drag > knee) drag = room - knee * knee / drag;
    if (k->push > 0.0f) { /* a parabola, whose area is the push */
        const float t = k->knocking + 0.5f * step;
        const float speed = knob_abs(k->u - k->trail) / (TRAIL_S * KNOB_PER_RAD);
        const float part = speed < KNOCK_SPEED ? speed / KNOCK_SPEED : 1.0f;
        drag += 6.0f / KNOCK_S * k->push * t * (1.0f - t) * part;
        k->knocking += step;
        if (k->knocking > 1.0f - 0.5f * step) k->push = 0.0f;
    }
    return (drag < room ? drag : room) / (1.0f + slower * slower);
}

/* --- the knob --------------------------------------------------------------------------------- */

static inline void knob_begin(Knob *k, float shaft) {
    memset(k, 0, sizeof *k);
    k->disk.per_rad = 1.0f;
    k->sign = 1.0f;
    k->silent = KNOB_SILENT;
    k->origin = k->shaft = shaft;
}

/* End the torque at once; it rises again from 0 while the host sends frames. */
static inline void knob_release(Knob *k) {
    k->level = 0.0f;
    knob_rest(k);
}

/* Raise the level of the torque while the host sends frames and plays; else lower it to 0. */
static void knob_watch(Knob *k) {
    int alive = k->silent < KNOB_SILENT && k->disk_id && k->active_id && k->playing &&
                !k->changing;
    if (k->silent < KNOB_SILENT) k->silent++;
    if (!alive) {
        k->level -= KNOB_FALL;
        if (k->level <= 0.0f) {
            k->level = 0.0f;
            knob_rest(k);
        }
        return;
    }
    k->level = k->level + KNOB_RISE < 1.0f ? k->level + KNOB_RISE : 1.0f;
    k->home_level = k->home_level + KNOB_HOME_RISE < 1.0f ? k->home_level + KNOB_HOME_RISE : 1.0f;
    if (k->fade > 0.0f) k->fade = k->fade > k->fade_step ? k->fade - k->fade_step : 0.0f;
}

/* The pull to the start and the two ends, N m. It depends on the hand's angle alone and is always
below the ceiling, so that all energy it stores is given back. */
static float knob_pull(const Knob *k, float u) {
    const float end = (float)(KNOB_POINTS - 1);
    float home = k->home_level * k->home * knob_clamped(u, 0.0f, end);
    float beyond = u < 0.0f ? u : u > end ? u - end : 0.0f;
    float most = KNOB_PULL * k->disk.ceiling - home;
    return -home - knob_clamped(k->end * beyond, -KNOB_PULL * k->disk.ceiling, most > 0.0f ? most : 0.0f);
}

/* How far the hand moves in `steps`, cells: estimated to the second order, as otherwise a stiff end
would amplify a tremor at 1000 steps a second. */
static float knob_moves(const Knob *k, float steps) {
    const float half = k->latest[(k->at + KNOB_MEAN - KNOB_HALF) % KNOB_MEAN];
    const float first = k->latest[(k->at + KNOB_MEAN - 2 * KNOB_HALF) % KNOB_MEAN];
    const float now = (k->u - half) / KNOB_HALF, before = (half - first) / KNOB_HALF;
    return steps * (now + (now - before) * (0.5f + 0.5f * steps / KNOB_HALF));
}

/* Bend the brush with the hand, which turns by `speed` cells per step. */
static void knob_bend(Knob *k, float speed) {
    const float turn = KNOB_PER_RAD * knob_abs(k->disk.per_rad), before = k->ahead;
    const float ahead = k->u + speed * ((KNOB_LATE_S + BRUSH_S) * KNOB_HZ + 0.5f);
    k->ahead += (ahead - k->ahead) / (BRUSH_S * KNOB_HZ + 1.0f);
    k->brush += (k->ahead - before) / (turn * BRUSH_STEPS * KNOB_RESOLUTION);
    k->brush = knob_clamped(k->brush, -1.0f, 1.0f);
    k->trail += (k->u - k->trail) / (TRAIL_S * KNOB_HZ + 1.0f);
    speed = knob_abs(speed) * (KNOB_HZ / KNOB_PER_RAD);
    k->fastest -= k->fastest / (BRAKE_S * KNOB_HZ);
    if (k->fastest < speed) k->fastest = speed;
}

/* Return the torque (N m along the shaft) to apply until the next call; `shaft`: its angle, rad. */
static inline float knob_step(Knob *k, float shaft) {
    float speed, ahead, torque, stretch = 0.0f;
    int n;
    if (!(knob_abs(shaft) < 1e6f)) shaft = k->shaft; /* true for a NaN as well */
    k->shaft = shaft;
    k->u = (shaft - k->origin) * k->disk.per_rad * KNOB_PER_RAD;
    speed = (k->u - k->latest[k->at]) / KNOB_MEAN; /* cells per step */
    ahead = knob_moves(k, KNOB_LATE_S * KNOB_HZ + 0.5f);
    k->latest[k->at] = k->u;
    k->at = (uint8_t)((k->at + 1) % KNOB_MEAN);
    knob_watch(k);
    if (k->level <= 0.0f) return 0.0f;
    k->pull = knob_pull(k, k->u + ahead);
    knob_bend(k, speed);
    for (n = 0; n < KNOB_SUBSTEPS; n++)
        stretch += knob_move(k, k->u + speed * ((float)n + 0.5f) / KNOB_SUBSTEPS) / KNOB_SUBSTEPS;
    k->used = STIFFER * stretch;
    torque = k->pull - k->brush * knob_brake(k, stretch);
    torque = knob_clamped(torque, -k->disk.ceiling, k->disk.ceiling);
    k->torque = k->sign * k->level * torque;
    return k->torque;
}

/* --- the serial line --------------------------------------------------------------------------- */

static uint16_t knob_crc(const uint8_t *data, int count) { /* CRC-16/X-25 */
    uint16_t crc = 0xFFFF;
    int bit;
    while (count--) {
        crc ^= *data++;
        for (bit = 0; bit < 8; bit++) crc = (uint16_t)(crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1);
    }
    return (uint16_t)(crc ^ 0xFFFF);
}

static uint16_t knob_get(const uint8_t *data) { return (uint16_t)(data[0] | (uint16_t)data[1] << 8); }

static void knob_take_disk(Knob *k, const uint8_t *payload) {
    k->changing = payload[1] != k->disk_id;
    if (!k->changing || k->level > 0.0f) return; /* never while there is torque: the host sends it again */
    k->changing = 0;
    memcpy(&k->disk, payload + 3, sizeof k->disk);
    k->disk_id = payload[1];
    if (payload[2]) k->origin = k->shaft;
    knob_derive(k);
}

static void knob_take_part(Knob *k, const uint8_t *payload) {
    uint16_t part = knob_get(payload + 2), *points = k->points[1 - k->slot];
    int first = KNOB_PART_POINTS * part, count = KNOB_POINTS, n;
    if (payload[1] == k->active_id || k->fade > 0.0f || part >= KNOB_ALL_PARTS) return;
    if (part >= KNOB_PARTS) {
        points = &k->events[1 - k->slot][0].first;
        first = 3 * KNOB_PART_EVENTS * (part - KNOB_PARTS);
        count = first + 3 * KNOB_PART_EVENTS;
    }
    if (payload[1] != k->filling_id) {
        k->filling_id = payload[1];
        k->missing = 0;
        memset(k->have, 0, sizeof k->have);
    }
    for (n = 0; n < KNOB_PART_POINTS && first + n < count; n++)
        points[first + n] = knob_get(payload + 4 + 2 * n);
    k->have[part / 8] |= (uint8_t)(1 << part % 8);
    while (k->missing < KNOB_ALL_PARTS && (k->have[k->missing / 8] >> k->missing % 8 & 1)) k->missing++;
}

static void knob_take_use(Knob *k, const uint8_t *payload) {
    uint16_t ms = knob_get(payload + 2);
    if (payload[1] != k->filling_id || payload[1] == k->active_id || k->missing < KNOB_ALL_PARTS) return;
    k->slot = (uint8_t)(1 - k->slot);
    memcpy(&k->unit[k->slot], payload + 4, sizeof k->unit[0]);
    memset(k->near_by, 0, sizeof k->near_by);
    k->fade = k->active_id && ms ? 1.0f : 0.0f;
    k->fade_step = ms ? 1000.0f / ((float)ms * KNOB_HZ) : 1.0f;
    k->active_id = payload[1];
}

static int knob_take(Knob *k, const uint8_t *payload, int count) {
    if (payload[0] == KNOB_ALIVE && count == 2)
        k->playing = payload[1];
    else if (payload[0] == KNOB_DISK && count == 3 + (int)sizeof(KnobDisk))
        knob_take_disk(k, payload);
    else if (payload[0] == KNOB_PART && count == 4 + 2 * KNOB_PART_POINTS)
        knob_take_part(k, payload);
    else if (payload[0] == KNOB_USE && count == 4 + (int)sizeof(float))
        knob_take_use(k, payload);
    else
        return 0;
    k->silent = 0;
    return 1;
}

/* Take a byte from the host; return 1 if it ended a frame that was understood. */
static inline int knob_receive(Knob *k, uint8_t byte) {
    uint8_t *frame = k->frame;
    int count = k->length, at, next;
    uint16_t crc;
    if (byte) {
        if (k->length < KNOB_LONGEST) frame[k->length++] = byte;
        return 0;
    }
    k->length = 0;
    if (!count) return 0;
    count -= 3;
    crc = count > 1 ? knob_crc(frame, count) : 0;
    if (count < 2 || frame[count] != (0x80 | (crc & 0x7F)) ||
        frame[count + 1] != (0x80 | (crc >> 7 & 0x7F)) || frame[count + 2] != (0x80 | crc >> 14)) {
        k->refused++;
        return 0;
    }
    for (at = 0; at < count; at = next) { /* COBS: put a zero in place of each distance */
        next = at + frame[at];
        if (next > count) return 0;
        frame[at] = 0;
    }
    return knob_take(k, frame + 1, count - 1);
}

static void knob_put(uint8_t *out, uint32_t value, int bytes) {
    while (bytes--) {
        *out++ = (uint8_t)value;
        value >>= 8;
    }
}

static int32_t knob_rounded(float x, float most) {
    x = knob_clamped(x, -most, most);
    return (int32_t)(x < 0.0f ? x - 0.5f : x + 0.5f);
}

/* Write the next 24 bytes to send: the motion, or at every sixteenth call the state. */
static inline int knob_report(Knob *k, uint32_t now_us, uint8_t *out) {
    uint8_t payload[19];
    int state = k->sequence % 16 == 0, code = 0, at = 1, n;
    uint16_t crc;
    payload[0] = (uint8_t)(state ? KNOB_STATE : KNOB_MOTION);
    knob_put(payload + 1, k->sequence++, 2);
    knob_put(payload + 3, now_us, 4);
    if (state) {
        knob_put(payload + 7, KNOB_POINTS, 2);
        knob_put(payload + 9, KNOB_HZ, 2);
        knob_put(payload + 11, k->missing, 2);
        payload[13] = k->filling_id;
        payload[14] = k->active_id;
        payload[15] = k->disk_id;
        payload[16] = (uint8_t)(255.0f * k->level);
        knob_put(payload + 17, k->refused, 2);
    } else { /* the hand's and the disk's angle, urad; torque, 10 uN m; the spring's stretch, 0.1 mrad */
        knob_put(payload + 7, (uint32_t)knob_rounded(k->u / KNOB_PER_RAD * 1e6f, 2e9f), 4);
        knob_put(payload + 11, (uint32_t)knob_rounded(k->x / KNOB_PER_RAD * 1e6f, 2e9f), 4);
        knob_put(payload + 15, (uint32_t)knob_rounded(k->sign * k->torque * 1e5f, 32767.0f), 2);
        knob_put(payload + 17, (uint32_t)knob_rounded(k->used / KNOB_PER_RAD * 1e4f, 32767.0f), 2);
    }
    for (n = 0; n < 19; n++) {
        if (payload[n]) {
            out[at++] = payload[n];
        } else {
            out[code] = (uint8_t)(at - code);
            code = at++;
        }
    }
    out[code] = (uint8_t)(at - code);
    crc = knob_crc(out, 20);
    out[20] = (uint8_t)(0x80 | (crc & 0x7F));
    out[21] = (uint8_t)(0x80 | (crc >> 7 & 0x7F));
    out[22] = (uint8_t)(0x80 | crc >> 14);
    out[23] = 0;
    return 24;
}

#endif
