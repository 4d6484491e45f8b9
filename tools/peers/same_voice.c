/* The whole voice in C: the algorithm of overview_dsp/kernels/ for a surface of viscous friction, with
 * the same bits. A yardstick for the compiled kernels, and a second reading of them.
 *
 *     gcc -O3 -march=native -ffp-contract=off -shared -fPIC same_voice.c -o same_voice.so -lm
 *
 * Contracted or reordered arithmetic gives other bits: no -ffast-math, no -ffp-contract=fast.
 * One hand; surfaces and parameters stand still; bristles, detents and end stops are left out.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "layout.h"

static const double PI = 3.141592653589793;
static const double FAR_AWAY = 1e300, RETREAT = 1e-6, STANDSTILL = 1e-150, STILL = 1e-150;

/* as kernels/layout.py has them, from COEFF on */
typedef struct {
    double spring_held, spring_free, inertia, theta, omega, smooth, torque, gate, exponent, decay,
        rise, carrier, tactor_gain, click_gain, strike_torque, strike_exponent, texture_gain,
        texture_cutoff, ceiling, dc_pole, grain, forget, catch_up, unfold, pacing, pace_least,
        pace_most;
} Coefficients;

#define IS_COLUMN(type, member, column, start) \
    _Static_assert(offsetof(type, member) == 8 * ((column) - (start)), #member)
IS_COLUMN(Coefficients, smooth, C_SMOOTH, COEFF);
IS_COLUMN(Coefficients, carrier, C_CARRIER, COEFF);
IS_COLUMN(Coefficients, strike_torque, C_STRIKE_TORQUE, COEFF);
IS_COLUMN(Coefficients, ceiling, C_CEILING, COEFF);
IS_COLUMN(Coefficients, forget, C_FORGET, COEFF);
IS_COLUMN(Coefficients, pace_most, C_PACE_MOST, COEFF);

/* a mode of a surface */
typedef struct {
    double re[2 * PHASES], im[2 * PHASES], cos, sin, turns, decay, gain, unused[3];
} Mode;

IS_COLUMN(Mode, im, MODE_IM, MODE_RE);
IS_COLUMN(Mode, cos, MODE_COS, MODE_RE);
IS_COLUMN(Mode, gain, MODE_GAIN, MODE_RE);
_Static_assert(sizeof(Mode) == 8 * MODE_SIZE, "Mode");

/* a surface slot, and the clicks of each kind */
typedef struct {
    const double *table; /* pairs of friction and its slope, CELLS + 1 of them */
    const double *integral; /* of friction, [CELLS + 1] */
    const int64_t *steep; /* [CELLS / STEEP_BLOCK + 1] */
    int64_t events;
    const double *lower; /* edges of events, ascending, and whose they are */
    const int64_t *lower_event;
    const double *upper;
    const int64_t *upper_event;
    const double *release;
    const int64_t *kind;
    const int64_t *modes, *ring; /* [BANKS] */
    const Mode *mode; /* [BANKS * MAX_MODES] */
} Surface;

typedef struct {
    int64_t sample, touching;
    double theta2;
} Control;

typedef struct {
    double time, level;
    int64_t event;
} Strike;

typedef struct {
    double re[MAX_MODES][PHASES], im[MAX_MODES][PHASES], c[MAX_MODES], s[MAX_MODES];
    int64_t left, modes;
} Bank;

typedef struct {
    int64_t clock, touching, next_lower, next_upper, strikes, sounded[CONTACT], ringing, ringing_kind[BANKS];
    uint64_t noise;
    double x, v, input, smooth_1, smooth_2, approach, phase, pace;
    double follower, envelope_1, envelope_2, tactor_in, tactor_out;
    double grain, texture, click_in, click_out;
    Bank bank[BANKS];
    Strike queue[STRIKE_LOG];
} Voice;

/* --- elementary functions: kernels/elementary.py ------------------------------------------- */

static const double LOG2_E = 1.4426950408889634, LN_2 = 0.6931471805599453;
static const double TURN = 6.283185307179586, ROUND = 6755399441055744.0;
#define ONE_BITS 0x3FF0000000000000
#define ROOT_HALF_BITS 0x3FE6A09E667F3BCD
#define TWO_52_BITS 0x4330000000000000

static inline int64_t bits_of(double x) {
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double double_of(int64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline double log_2(double x) {
    int64_t bits = bits_of(x);
    int64_t exponent = (bits + (ONE_BITS - ROOT_HALF_BITS)) >> 52;
    double f = double_of(bits - ((exponent - 1023) << 52));
    double s = (f - 1.0) / (f + 1.0);
    double t = s * s;
    double t2 = t * t;
    double high = (1.0 / 9.0 + t * (1.0 / 11.0)) + t2 * (1.0 / 13.0);
    double low = (1.0 + t * (1.0 / 3.0)) + t2 * (1.0 / 5.0 + t * (1.0 / 7.0));
    double whole = double_of(exponent | TWO_52_BITS) - (4503599627370496.0 + 1023.0);
    return whole + (2.0 * LOG2_E) * s * (low + t2 * t2 * high);
}

static inline double exp_2(double y) {
    y = y < -1000.0 ? -1000.0 : y;
    y = y > 1000.0 ? 1000.0 : y;
    double rounded = y + ROUND;
    double z = (y - (rounded - ROUND)) * LN_2;
    double z2 = z * z;
    double z4 = z2 * z2;
    double low = (1.0 + z) + z2 * (0.5 + z * (1.0 / 6.0));
    double middle = (1.0 / 24.0 + z * (1.0 / 120.0)) + z2 * (1.0 / 720.0 + z * (1.0 / 5040.0));
    double high = (1.0 / 40320.0 + z * (1.0 / 362880.0)) + z2 * (1.0 / 3628800.0);
    double series = low + z4 * (middle + z4 * high);
    return series * double_of((int64_t)((uint64_t)bits_of(rounded) << 52) + ONE_BITS);
}

static inline double power(double x, double p) { return exp_2(p * log_2(x)); }

static inline double tanh_positive(double x) {
    return 1.0 - 2.0 / (exp_2(2.0 * LOG2_E * x) + 1.0);
}

static inline double sin_turns(double p) {
    double rounded = 2.0 * p + ROUND;
    double x = (p - 0.5 * (rounded - ROUND)) * TURN;
    double t = x * x;
    double t2 = t * t;
    double t4 = t2 * t2;
    double low = (1.0 - t * (1.0 / 6.0)) + t2 * (1.0 / 120.0 - t * (1.0 / 5040.0));
    double high = (1.0 / 362880.0 - t * (1.0 / 39916800.0)) +
                  t2 * (1.0 / 6227020800.0 - t * (1.0 / 1307674368000.0));
    double s = x * (low + t4 * (high + t4 * (1.0 / 355687428096000.0)));
    return double_of(bits_of(s) ^ (int64_t)((uint64_t)bits_of(rounded) << 63));
}

static inline double cos_turns(double p) { return sin_turns(p + 0.25); }

/* --- strikes and modes: kernels/click.py --------------------------------------------------- */

static void strike(Voice *voice, const Coefficients *c, const Surface *surface, int64_t event,
                   double approach, int64_t sample, double fraction) {
    double hardness = surface->release[event] * approach * c->strike_torque;
    double level = 0.0;
    if (hardness > 1e-12) {
        level = power(hardness, c->strike_exponent);
        level = level / (1.0 + level);
    }
    Strike *entry = &voice->queue[voice->strikes % STRIKE_LOG];
    entry->time = (double)sample + fraction;
    entry->level = level;
    entry->event = event;
    voice->strikes += 1;
}

static void pulse(Voice *voice, const Surface *surface, const Strike *entry, int number, double rest,
                 int64_t sample) {
    int64_t kind = surface->kind[entry->event];
    int64_t modes = surface->modes[kind];
    if (modes == 0) return;
    Bank *bank = &voice->bank[kind];
    if (bank->left == 0) voice->ringing_kind[voice->ringing++] = kind;
    bank->left = surface->ring[kind];
    bank->modes = modes;
    double weight = 0.125 - 0.125 * cos_turns(((double)number + 0.5) * (1.0 / CONTACT));
    double level = entry->level * weight;
    for (int64_t j = 0; j < modes; j++) {
        const Mode *mode = &surface->mode[kind * MAX_MODES + j];
        double turns = mode->turns * rest;
        double decay = exp_2(mode->decay * rest * LOG2_E);
        double amplitude = level * mode->gain;
        double re = amplitude * (decay * cos_turns(turns));
        double im = amplitude * (decay * sin_turns(turns));
        int64_t first = -sample & (PHASES - 1); /* of the rotations, that which phase 0 gets */
        for (int phase = 0; phase < PHASES; phase++) {
            int64_t at = first + phase;
            bank->re[j][phase] += re * mode->re[at] - im * mode->im[at];
            bank->im[j][phase] += re * mode->im[at] + im * mode->re[at];
        }
        bank->c[j] = mode->cos;
        bank->s[j] = mode->sin;
    }
}

/* The sample in which the next pulse falls, of strikes not sounded in full; or INT64_MAX. */
static int64_t sound_strikes(Voice *voice, const Surface *surface, int64_t sample) {
    int64_t due = INT64_MAX;
    for (int number = 0; number < CONTACT; number++) {
        while (voice->sounded[number] < voice->strikes) {
            const Strike *entry = &voice->queue[voice->sounded[number] % STRIKE_LOG];
            double time = entry->time + (double)number * 0.5;
            double rest = (double)(sample + 1) - time;
            if (rest < 0.0) {
                int64_t later = (int64_t)time;
                if ((double)later == time) later -= 1;
                if (later < due) due = later;
                break;
            }
            pulse(voice, surface, entry, number, rest, sample);
            voice->sounded[number] += 1;
        }
    }
    return due;
}

static inline double turn(Bank *bank, int64_t j, int64_t phase) {
    double re = bank->re[j][phase], im = bank->im[j][phase], c = bank->c[j], s = bank->s[j];
    bank->re[j][phase] = c * re - s * im;
    bank->im[j][phase] = s * re + c * im;
    return im;
}

static double ring_once(Voice *voice, int64_t sample) {
    double total = 0.0;
    int64_t i = 0;
    while (i < voice->ringing) {
        Bank *bank = &voice->bank[voice->ringing_kind[i]];
        for (int64_t j = 0; j < bank->modes; j++) total += turn(bank, j, sample & (PHASES - 1));
        bank->left -= 1;
        if (bank->left == 0) {
            memset(bank->re, 0, sizeof bank->re);
            memset(bank->im, 0, sizeof bank->im);
            voice->ringing -= 1;
            voice->ringing_kind[i] = voice->ringing_kind[voice->ringing];
        } else {
            i += 1;
        }
    }
    return total;
}

/* four phases as one value, for any vectors that there are */
typedef double Four __attribute__((vector_size(32)));

static inline Four four(const double *from) {
    Four x;
    memcpy(&x, from, sizeof x);
    return x;
}

static void ring_mode(Bank *bank, int64_t j, int64_t clock, double *rung, int64_t frames) {
    int64_t n = 0;
    for (; n < frames && ((clock + n) & (PHASES - 1)) != 0; n++)
        rung[n] += turn(bank, j, (clock + n) & (PHASES - 1));
    double c = bank->c[j], s = bank->s[j];
    Four re = four(bank->re[j]), im = four(bank->im[j]);
    Four re2 = four(bank->re[j] + 4), im2 = four(bank->im[j] + 4);
    for (; n + PHASES <= frames; n += PHASES) {
        Four sum = four(rung + n) + im, sum2 = four(rung + n + 4) + im2;
        memcpy(rung + n, &sum, sizeof sum);
        memcpy(rung + n + 4, &sum2, sizeof sum2);
        Four turned = c * re - s * im, turned2 = c * re2 - s * im2;
        im = s * re + c * im;
        im2 = s * re2 + c * im2;
        re = turned;
        re2 = turned2;
    }
    memcpy(bank->re[j], &re, sizeof re);
    memcpy(bank->im[j], &im, sizeof im);
    memcpy(bank->re[j] + 4, &re2, sizeof re2);
    memcpy(bank->im[j] + 4, &im2, sizeof im2);
    for (; n < frames; n++) rung[n] += turn(bank, j, (clock + n) & (PHASES - 1));
}

static void ring_on(Voice *voice, int64_t clock, double *rung, int64_t frames) {
    memset(rung, 0, frames * sizeof *rung);
    for (int64_t i = 0; i < voice->ringing; i++) {
        Bank *bank = &voice->bank[voice->ringing_kind[i]];
        bank->left -= frames;
        for (int64_t j = 0; j < bank->modes; j++) ring_mode(bank, j, clock, rung, frames);
    }
}

/* What rings in one chunk: in runs, between pulses and kinds that fall silent. */
static void ring(Voice *voice, const Surface *surface, double *rung, int64_t frames) {
    int64_t n = 0;
    while (n < frames) {
        int64_t stop = frames;
        if (voice->sounded[CONTACT - 1] < voice->strikes) {
            int64_t due = sound_strikes(voice, surface, voice->clock + n);
            if (due - voice->clock < stop) stop = due - voice->clock;
        }
        for (int64_t i = 0; i < voice->ringing; i++) {
            int64_t last = n + voice->bank[voice->ringing_kind[i]].left - 1;
            if (last < stop) stop = last;
        }
        if (stop > n + 1) {
            ring_on(voice, voice->clock + n, rung + n, stop - n);
            n = stop;
        } else {
            rung[n] = ring_once(voice, voice->clock + n);
            n += 1;
        }
    }
}

/* --- the stages of a chunk: kernels/motion.py, shaping.py, voice.py, output.py ------------- */

typedef struct {
    double torque[CHUNK], omega[CHUNK], phase[CHUNK];
    double amplitude[CHUNK], sine[CHUNK], grain[CHUNK], colour[CHUNK], rung[CHUNK];
    double click[CHUNK], tactor[CHUNK];
} Chunk;

/* kernels/two_disk.py */
static const double SHORT = 1.0 / 64.0;
enum { ROUNDS = 2 };

static inline double clamped(double x) {
    x = x > 0.0 ? x : 0.0;
    return x > CELLS ? CELLS : x;
}

static inline double friction_at(const Surface *surface, double x) {
    x = clamped(x);
    int64_t i = (int64_t)x;
    return surface->table[2 * i] + (x - (double)i) * surface->table[2 * i + 1];
}

static double integral_at(const Surface *surface, double x) {
    double inside = clamped(x);
    int64_t i = (int64_t)inside;
    double part = inside - (double)i, friction = surface->table[2 * i];
    double beyond = (x - inside) * friction;
    return surface->integral[i] + part * (friction + 0.5 * part * surface->table[2 * i + 1]) + beyond;
}

/* Where the next edge is passed upwards, and the last one again downwards. */
static double edge_above(const double *edges, int64_t count, int64_t next) {
    return next < count ? edges[next] : FAR_AWAY;
}

static double edge_below(const double *edges, int64_t next) {
    return next > 0 ? edges[next - 1] - RETREAT : -FAR_AWAY;
}

static double least(double a, double b) { return a < b ? a : b; }

static double greatest(double a, double b) { return a > b ? a : b; }

/* Strike every event entered between `was` and x: kernels/event_crossing.py */
static void pass_events(Voice *voice, const Coefficients *c, const Surface *surface, double x,
                        double was, double approach, int64_t sample) {
    int64_t count = surface->events;
    double edge = edge_above(surface->lower, count, voice->next_lower);
    while (x >= edge) {
        int64_t event = surface->lower_event[voice->next_lower++];
        strike(voice, c, surface, event, approach, sample, (edge - was) / (x - was));
        edge = edge_above(surface->lower, count, voice->next_lower);
    }
    while (x < edge_below(surface->lower, voice->next_lower)) voice->next_lower--;
    while (x >= edge_above(surface->upper, count, voice->next_upper)) voice->next_upper++;
    while (x < edge_below(surface->upper, voice->next_upper)) {
        voice->next_upper--;
        edge = surface->upper[voice->next_upper];
        strike(voice, c, surface, surface->upper_event[voice->next_upper], approach, sample,
               was > edge ? (was - edge) / (was - x) : 0.0);
    }
}

static void move(Voice *voice, const Coefficients *c, const Surface *surface, Chunk *chunk,
                 int64_t frames) {
    double x = voice->x, half = 0.5 * voice->v, y1 = voice->smooth_1, y2 = voice->smooth_2;
    double phase = voice->phase, approach = voice->approach;
    double target = voice->input, pace = voice->pace;
    double spring = voice->touching ? c->spring_held : c->spring_free;
    double denominator = c->inertia * (2.0 + 0.5 * spring);
    double above = -FAR_AWAY, below = FAR_AWAY; /* looked up at the first sample */

    for (int64_t n = 0; n < frames; n++) {
        double moved = y2;
        y1 = y1 + c->smooth * (target - y1);
        y2 = y2 + c->smooth * (y1 - y2);
        y1 = y1 > STILL ? y1 : 0.0;
        y2 = y2 > STILL ? y2 : 0.0;
        double friction = friction_at(surface, x + half);
        double stretch = voice->touching ? y2 - x : 0.0 - x;
        if (voice->touching) { /* kernels/clutch.py */
            moved = fabs(y2 - moved);
            if (moved > c->pace_least && moved < c->pace_most)
                pace = pace + c->pacing * (moved - pace);
            double way = fabs(stretch) * c->unfold;
            double reach = (way > pace ? way : pace) * (friction * c->catch_up);
            if (fabs(stretch) > reach) stretch = stretch > 0.0 ? reach : -reach;
        }
        double was = x;
        double middle = c->inertia * (4.0 * half + spring * stretch) / (denominator + friction);
        if (surface->steep[(int64_t)clamped(x + half) / STEEP_BLOCK]) { /* kernels/friction.py */
            double push = c->inertia * (4.0 * half + spring * stretch);
            double start = integral_at(surface, x);
            for (int round = 0; round < ROUNDS; round++) {
                double taken = integral_at(surface, x + middle) - start;
                double there = friction_at(surface, x + middle);
                middle = middle - (middle * denominator + taken - push) / (denominator + there);
            }
            friction = fabs(middle) > SHORT
                           ? (integral_at(surface, x + middle) - start) / middle
                           : friction_at(surface, x + 0.5 * middle);
            middle = push / (denominator + friction);
        }
        x = x + middle;
        half = middle - half;
        half = fabs(half) < 0.5 * STANDSTILL ? 0.0 : half;
        x = fabs(x) < STANDSTILL ? 0.0 : x;
        double omega = middle * c->omega;
        approach = approach * c->forget;
        approach = fabs(omega) > approach ? fabs(omega) : approach;
        approach = approach < STANDSTILL ? 0.0 : approach;
        phase = phase + c->carrier;
        phase = phase >= 1.0 ? phase - 1.0 : phase;
        chunk->torque[n] = friction * omega;
        chunk->omega[n] = omega;
        chunk->phase[n] = phase;

        if (x >= above || x < below) {
            pass_events(voice, c, surface, x, was, approach, voice->clock + n);
            above = least(edge_above(surface->lower, surface->events, voice->next_lower),
                          edge_above(surface->upper, surface->events, voice->next_upper));
            below = greatest(edge_below(surface->lower, voice->next_lower),
                             edge_below(surface->upper, voice->next_upper));
        }
    }
    voice->x = x;
    voice->v = 2.0 * half;
    voice->smooth_1 = y1;
    voice->smooth_2 = y2;
    voice->phase = phase;
    voice->approach = approach;
    voice->pace = pace;
}

static void shape(const Coefficients *c, Chunk *chunk, int64_t frames) {
    for (int64_t n = 0; n < frames; n++) {
        double t = fabs(chunk->torque[n]) * c->torque - c->gate;
        int felt = t > 1e-12;
        double a = power(felt ? t : 1.0, c->exponent);
        a = a < 3.0 ? a : 3.0;
        a = felt ? a : 0.0;
        double squared = a * a;
        chunk->amplitude[n] = a * (27.0 + squared) / (27.0 + 9.0 * squared);
        chunk->sine[n] = sin_turns(chunk->phase[n]);
        chunk->grain[n] = c->texture_gain * sqrt(fabs(chunk->torque[n] * chunk->omega[n]));
        double bright = c->texture_cutoff * (fabs(chunk->omega[n]) + 0.05);
        chunk->colour[n] = bright / (1.0 + bright);
    }
}

static inline double block_dc(double x, double x_before, double y_before, double pole) {
    double y = x - x_before + pole * y_before;
    return x == 0.0 && fabs(y) < 1e-9 ? 0.0 : y;
}

static void sound(Voice *voice, const Coefficients *c, Chunk *chunk, int64_t frames) {
    double follower = voice->follower, e1 = voice->envelope_1, e2 = voice->envelope_2;
    double tactor_in = voice->tactor_in, tactor_out = voice->tactor_out;
    double click_in = voice->click_in, click_out = voice->click_out;
    double level = voice->grain, grain = voice->texture;
    uint64_t noise = voice->noise;
    for (int64_t n = 0; n < frames; n++) {
        double amplitude = chunk->amplitude[n];
        follower =
            amplitude > follower ? amplitude : follower + c->decay * (amplitude - follower);
        if (amplitude == 0.0 && follower < 1e-7) follower = 0.0;
        e1 = e1 + c->rise * (follower - e1);
        e2 = e2 + c->rise * (e1 - e2);
        if (follower == 0.0 && e1 + e2 < 1e-7) e1 = e2 = 0.0;
        double wave = e2 * c->tactor_gain * chunk->sine[n];
        tactor_out = block_dc(wave, tactor_in, tactor_out, c->dc_pole);
        tactor_in = wave;
        chunk->tactor[n] = tactor_out;

        double target = chunk->grain[n];
        level = level + c->grain * (target - level);
        if (level <= 1e-5 && target < 1e-5) level = 0.0;
        double rough = 0.0;
        if (level > 0.0) {
            noise = noise ^ (noise >> 12);
            noise = noise ^ (noise << 25);
            noise = noise ^ (noise >> 27);
            int64_t drawn = (int64_t)((noise * 2685821657736338717u) >> 11);
            rough = level * ((double)drawn * 2.220446049250313e-16 - 1.0);
        }
        grain = grain + (rough - grain) * chunk->colour[n];
        if (rough == 0.0 && fabs(grain) < 1e-5) grain = 0.0;
        double clicks = (grain + chunk->rung[n]) * c->click_gain;
        click_out = block_dc(clicks, click_in, click_out, c->dc_pole);
        click_in = clicks;
        chunk->click[n] = click_out;
    }
    voice->follower = follower;
    voice->envelope_1 = e1;
    voice->envelope_2 = e2;
    voice->tactor_in = tactor_in;
    voice->tactor_out = tactor_out;
    voice->click_in = click_in;
    voice->click_out = click_out;
    voice->grain = level;
    voice->texture = grain;
    voice->noise = noise;
}

static void emit(const double *x, int64_t frames, double ceiling, float *out) {
    double knee = 0.5 * ceiling, room = 0.999999 * ceiling - knee;
    for (int64_t n = 0; n < frames; n++) {
        double y = x[n];
        if (fabs(y) > knee) {
            double held = knee + room * tanh_positive((fabs(y) - knee) / room);
            y = y > 0.0 ? held : -held;
        }
        out[2 * n] = (float)y;
    }
}

static void control(Voice *voice, const Coefficients *c, const Control *event) {
    double place = event->theta2 * (CELLS / PI);
    if (event->touching) {
        voice->input = place;
        if (!voice->touching) {
            voice->smooth_1 = voice->smooth_2 = place;
            voice->pace = c->unfold * CELLS;
        }
    }
    voice->touching = event->touching;
}

/* --- for callers ---------------------------------------------------------------------------- */

int64_t voice_size(void) { return sizeof(Voice); }

void voice_reset(Voice *voice, uint64_t seed) {
    memset(voice, 0, sizeof *voice);
    voice->noise = seed;
}

/* `frames` frames from the present one on into out, float32 [frames * 2] (click, tactor); of the
 * `count` events, in order, those are applied that fall due. */
void voice_render(Voice *voice, const Coefficients *c, const Surface *surface,
                  const Control *events, int64_t count, float *out, int64_t frames) {
    Chunk chunk;
    int64_t next = 0, end = voice->clock + frames;
    while (next < count && events[next].sample < voice->clock) next++;
    while (voice->clock < end) {
        while (next < count && events[next].sample <= voice->clock) control(voice, c, &events[next++]);
        int64_t stop = next < count && events[next].sample < end ? events[next].sample : end;
        while (voice->clock < stop) {
            int64_t length = stop - voice->clock < CHUNK ? stop - voice->clock : CHUNK;
            move(voice, c, surface, &chunk, length);
            shape(c, &chunk, length);
            ring(voice, surface, chunk.rung, length);
            sound(voice, c, &chunk, length);
            emit(chunk.click, length, c->ceiling, out);
            emit(chunk.tactor, length, c->ceiling, out + 1);
            voice->clock += length;
            out += 2 * length;
        }
    }
}
