/* The surface on a motor knob's own board: disk 1, its spring, its knocks and the serial protocol.

The host sends a friction table once; from then on the board pulls a disk over it with its own
encoder's angle, so that the delay of the serial line doesn't matter to the feel. One file for
boards, emulators and tools: C99 and C++, float, no libm, no allocation. The same bytes and angles
give the same bits of torque wherever products and sums aren't contracted (-ffp-contract=off; set
below for GCC and clang).

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

with u in the middle of the coming step, and the knob feels the spring in that middle,

    torque = -gain * (e - vm/2) - home * u - ends - knock,

so that the work of the hand equals the energy stored in the spring, to the second order. The slip
clutch is that of overview_dsp/kernels/clutch.py. Two things could return more energy to the hand
than it put in: the clutch when it stops slipping, and the knock (the disk's own deceleration,
low-passed, as a brake). Both take their energy from one `ledger`, which is credited with part of
the energy lost in the table's friction, up to LEDGER_J. */
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

enum {
    KNOB_DISK = 16, KNOB_PART, KNOB_USE, KNOB_ALIVE, /* kinds of frames from the host, */
    KNOB_MOTION = 6, KNOB_STATE,                     /* and to it, as in devices/sensors/frames.py */
    KNOB_PART_POINTS = 32,
    KNOB_PARTS = (KNOB_POINTS - 1) / KNOB_PART_POINTS + 1,
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
#define KNOB_PULL 0.8f /* of the ceiling, for the ends and the pull to the start */
#define LEDGER_J 7e-6f
#define LEDGER_PART 0.5f /* of the energy lost in friction, the part that is credited */
#define KNOCK_S 0.003f
#define KNOCK_PACE 1.0f /* rad/s of theta2: at this speed a knock is half as strong as at rest */
#define PACE_S 0.08f
#define PACE_LEAST 0.02f /* timelines a second, as in overview_dsp/kernels/derive.py */
#define PACE_MOST 6.0f

typedef struct { /* in a frame after the kind, an id and a flag: 1 = theta2 is 0 here */
    float inertia, k1, k2, catch_up, unfold_s, smoothing_s; /* the preset's disk */
    float gain, knock, home;                                /* the scale of each torque */
    float ceiling;                                          /* N m */
    float end;                                              /* N m/rad of theta2, beyond an end */
    float per_rad;                                          /* theta2 for one rad of the shaft */
} KnobDisk;

typedef struct { /* in a frame after the kind, the table's id and the cross-fade's ms */
    float unit; /* N m s/rad that a 1 in the table stands for */
    float hard; /* N m s/rad: at this friction a knock has half its strength */
} KnobTable;

typedef struct {
    /* from the host */
    KnobDisk disk;
    KnobTable table[2];
    uint16_t points[2][KNOB_POINTS];
    uint8_t have[(KNOB_PARTS + 7) / 8];
    uint8_t disk_id, active_id, filling_id, slot, playing, changing;
    uint16_t missing; /* the first part not received yet */
    uint32_t silent;  /* steps since the last frame */
    uint16_t refused; /* frames with a wrong checksum */
    uint8_t frame[KNOB_LONGEST];
    uint8_t length;
    /* derived from it */
    float inertia, spring, denominator, catch_, unfold, smoothing, pacing;
    float gain, home, end, energy, kinetic, loss, knock_gain, sign;
    /* the knob and its disk */
    float origin, shaft, u, before, latest[KNOB_MEAN];
    float x, v, stretch, y1, y2, pace;
    float level, home_level, fade, fade_step, pull;
    float low_pass, knock, way, extreme, ledger, torque, used;
    uint8_t at;
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
    return k->table[slot].unit * (a + (b - a) * (x - (float)i));
}

static float knob_friction(const Knob *k, float x) {
    float friction = knob_friction_of(k, k->slot, x);
    if (k->fade > 0.0f)
        friction += (knob_friction_of(k, 1 - k->slot, x) - friction) * k->fade;
    return friction;
}

/* Put the disk at the hand's angle, at rest and with the spring relaxed: no energy is stored. */
static void knob_rest(Knob *k) {
    k->x = k->before = k->y1 = k->y2 = k->extreme = k->u;
    k->v = k->stretch = k->low_pass = k->knock = k->ledger = k->torque = k->used = k->home_level = 0.0f;
    k->pace = k->unfold * (float)(KNOB_POINTS - 1);
}

static void knob_derive(Knob *k) {
    const KnobDisk *d = &k->disk;
    float sum = d->k1 + d->k2, part = d->k2 / sum, cell = 1.0f / KNOB_PER_RAD;
    float turn = knob_abs(d->per_rad), theta1 = part * cell;
    k->sign = d->per_rad < 0.0f ? -1.0f : 1.0f;
    k->inertia = d->inertia / KNOB_DT;
    k->spring = sum / d->inertia * KNOB_DT * KNOB_DT;
    k->denominator = k->inertia * (2.0f + 0.5f * k->spring);
    k->catch_ = d->catch_up > 0.0f ? d->catch_up / (sum * KNOB_DT) : 1e30f;
    k->unfold = d->unfold_s > 0.0f ? KNOB_DT / d->unfold_s : PACE_MOST * KNOB_DT;
    k->smoothing = KNOB_DT / (d->smoothing_s + KNOB_DT);
    k->pacing = KNOB_DT / (PACE_S + KNOB_DT);
    k->gain = d->gain * d->k2 * theta1;              /* N m per cell */
    k->home = d->home * d->gain * d->k1 * theta1;    /* the same */
    k->end = d->end * cell;                          /* the same */
    k->energy = 0.5f * k->gain * cell / turn;        /* J per cell squared, at the shaft */
    k->loss = d->gain / turn * theta1 * theta1 / KNOB_DT; /* J lost at 1 N m s/rad per (cell a step)^2 */
    k->kinetic = 0.5f * k->loss * k->inertia;
    k->knock_gain = d->gain * d->knock * d->inertia * theta1 / (KNOB_DT * KNOB_DT);
}

/* How far the spring is stretched where a rigid one would be by `stretch`: the clutch limits it,
the torque approaches the ceiling without reaching it, and the energy of a clutch that stops
slipping is taken from the ledger. */
static float knob_stretched(Knob *k, float stretch, float held, float friction) {
    float size = knob_abs(stretch), least = size * k->unfold, most, knee, needed;
    float pace = least > k->pace ? least : k->pace;
    float reach = pace * (friction * k->catch_);
    size = size > reach ? reach : size;
    most = (k->disk.ceiling - knob_abs(k->pull)) / k->gain;
    knee = 0.5f * most;
    if (size > knee) size = most - knee * knee / size;
    stretch = stretch < 0.0f ? -size : size;
    needed = k->energy * (size * size - held * held);
    if (needed > 0.0f) {
        if (needed > k->ledger) {
            float more = k->ledger / (2.0f * k->energy * size);
            size = knob_abs(held) + more; /* less than `size`, as its square is flatter */
            stretch = stretch < 0.0f ? -size : size;
            needed = k->ledger;
        }
        k->ledger -= needed;
    }
    return stretch;
}

/* Step the disk, with the hand at `u` in the middle of the step; return the mean stretch. */
static float knob_move(Knob *k, float u) {
    float moved, friction, held, before = k->v, middle, slowed, hard;
    float y2 = k->y2;
    k->y1 += k->smoothing * (u - k->y1);
    k->y2 += k->smoothing * (k->y1 - k->y2);
    moved = knob_abs(k->y2 - y2);
    if (moved > PACE_LEAST * (KNOB_POINTS - 1) * KNOB_DT && moved < PACE_MOST * (KNOB_POINTS - 1) * KNOB_DT)
        k->pace += k->pacing * (moved - k->pace);
    friction = knob_friction(k, k->x + 0.5f * k->v);
    held = k->stretch + (u - k->before);
    k->before = u;
    held = knob_stretched(k, u - k->x, held, friction);
    middle = k->inertia * (2.0f * k->v + k->spring * held) / (k->denominator + friction);
    k->x += middle;
    k->v = 2.0f * middle - k->v;
    k->stretch = held - middle;
    k->ledger += LEDGER_PART * k->loss * friction * middle * middle;
    if (k->ledger > LEDGER_J) k->ledger = LEDGER_J;
    slowed = knob_abs(before) - knob_abs(k->v);
    hard = k->table[k->slot].hard;
    if (slowed > 0.0f) k->low_pass += slowed * friction / (friction + hard) * (KNOB_DT / KNOCK_S);
    k->low_pass -= k->low_pass * (KNOB_DT / KNOCK_S);
    return held - 0.5f * middle;
}

/* The knock: a brake of at most `room`. The work of its last step is taken from the ledger here. */
static void knob_knock(Knob *k, float shaft, float room) {
    float turned = k->sign * (shaft - k->shaft), work = -k->way * k->knock * turned, most, pace;
    k->ledger -= work > 0.0f ? work : LEDGER_PART * work;
    k->ledger = knob_clamped(k->ledger, 0.0f, LEDGER_J);
    if (k->way * (k->u - k->extreme) >= 0.0f) {
        k->extreme = k->u;
    } else { /* the hand has turned back: a brake must not push it */
        k->way = -k->way;
        k->extreme = k->u;
        k->low_pass = 0.0f;
    }
    pace = k->pace / (KNOB_PER_RAD * KNOB_DT);
    k->knock = k->knock_gain * k->low_pass * KNOCK_PACE / (KNOCK_PACE + pace);
    if (k->knock > 0.5f * room) k->knock = room - 0.25f * room * room / k->knock;
    most = k->ledger / (1.25f * KNOB_RESOLUTION);
    if (k->knock > most) k->knock = most;
    if (room <= 0.0f) k->knock = 0.0f;
}

/* --- the knob --------------------------------------------------------------------------------- */

static inline void knob_begin(Knob *k, float shaft) {
    memset(k, 0, sizeof *k);
    k->disk.per_rad = 1.0f;
    k->sign = k->way = 1.0f;
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

/* How far the hand moves until the middle of the coming step, cells: estimated to the second order,
as otherwise a stiff end would amplify a tremor at 1000 steps a second. */
static float knob_ahead(const Knob *k) {
    const float half = k->latest[(k->at + KNOB_MEAN - KNOB_HALF) % KNOB_MEAN];
    const float first = k->latest[(k->at + KNOB_MEAN - 2 * KNOB_HALF) % KNOB_MEAN];
    const float now = (k->u - half) / KNOB_HALF, before = (half - first) / KNOB_HALF;
    return 0.5f * (now + (now - before) * (0.5f + 0.25f / KNOB_HALF));
}

/* Return the torque (N m along the shaft) to apply until the next call; `shaft`: its angle, rad. */
static inline float knob_step(Knob *k, float shaft) {
    float speed, ahead, torque, stretch = 0.0f;
    int n;
    if (!(knob_abs(shaft) < 1e6f)) shaft = k->shaft; /* true for a NaN as well */
    k->u = (shaft - k->origin) * k->disk.per_rad * KNOB_PER_RAD;
    speed = (k->u - k->latest[k->at]) / KNOB_MEAN; /* cells per step */
    ahead = knob_ahead(k);
    k->latest[k->at] = k->u;
    k->at = (uint8_t)((k->at + 1) % KNOB_MEAN);
    knob_watch(k);
    if (k->level <= 0.0f) {
        k->shaft = shaft;
        return 0.0f;
    }
    k->pull = knob_pull(k, k->u + ahead);
    for (n = 0; n < KNOB_SUBSTEPS; n++)
        stretch += knob_move(k, k->u + speed * ((float)n + 0.5f) / KNOB_SUBSTEPS) / KNOB_SUBSTEPS;
    torque = k->pull - k->gain * stretch;
    k->used = stretch;
    knob_knock(k, shaft, k->disk.ceiling - knob_abs(torque));
    torque -= k->way * k->knock;
    torque = knob_clamped(torque, -k->disk.ceiling, k->disk.ceiling);
    k->shaft = shaft;
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
    int first, n;
    if (payload[1] == k->active_id || k->fade > 0.0f || part >= KNOB_PARTS) return;
    first = KNOB_PART_POINTS * part;
    if (payload[1] != k->filling_id) {
        k->filling_id = payload[1];
        k->missing = 0;
        memset(k->have, 0, sizeof k->have);
    }
    for (n = 0; n < KNOB_PART_POINTS && first + n < KNOB_POINTS; n++)
        points[first + n] = knob_get(payload + 4 + 2 * n);
    k->have[part / 8] |= (uint8_t)(1 << part % 8);
    while (k->missing < KNOB_PARTS && (k->have[k->missing / 8] >> k->missing % 8 & 1)) k->missing++;
}

static void knob_take_use(Knob *k, const uint8_t *payload) {
    uint16_t ms = knob_get(payload + 2);
    if (payload[1] != k->filling_id || payload[1] == k->active_id || k->missing < KNOB_PARTS) return;
    k->slot = (uint8_t)(1 - k->slot);
    memcpy(&k->table[k->slot], payload + 4, sizeof k->table[0]);
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
    else if (payload[0] == KNOB_USE && count == 4 + (int)sizeof(KnobTable))
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
