/* A voice with timelines, presets, a hand and notes: what every plugin format plays.

   Threads: any may use `values`, `restored` and `chosen`, and call voice_tail; `missing`, `unnamed` and
   `in_place` belong to the main thread, as do voice_init, voice_activate and voice_deactivate, while
   nothing is processed. All else belongs to the audio thread while the voice is active, else to the
   main thread; it allocates and locks nothing. */
#ifndef OVERVIEW_VOICE_H
#define OVERVIEW_VOICE_H
#include "bundle.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { VOICE_THETA2, VOICE_TOUCH, VOICE_TIMELINE, VOICE_PRESET, VOICE_FOLLOW, VOICE_OWN };
enum { VOICE_VALUES = VOICE_OWN + OVERVIEW_PARAMETERS };
enum { VOICE_NAME = 256 }; /* bytes of a name in a project */
enum { VOICE_CHUNK = 256, VOICE_AT_ONCE = -1, VOICE_NO_NOTE = -1 };

static const double voice_pi = 3.141592653589793;
static const double voice_fade_s = 0.03; /* as of a surface that gives way to another */
static const double voice_follow_s = 0.002; /* from one place of the host's transport to the next */
static const double voice_silence_s = 0.05; /* so long, a zero is not one between two waves */

typedef struct {
    int first, count; /* which presets of the bundle */
    void *memories[2]; /* the image that plays and the one before; NULL while not active */
    const bundle_image *loaded[2];
    double rate;
    int current; /* of the memories */
    int64_t fade, fade_left; /* frames; above 0 the other memory is heard too */
    int waits; /* another image, until the fade is over */
    double applied[VOICE_VALUES]; /* what the memory was told */
    _Atomic double values[VOICE_VALUES]; /* what the host sees */
    atomic_bool restored; /* values that the memory wasn't told yet */
    char missing[2][VOICE_NAME]; /* main thread: timeline and preset of a project, if not in the bundle */
    int unnamed[2]; /* main thread: whether the project names no timeline and no preset */
    int in_place[2]; /* main thread: what plays instead */
    atomic_bool chosen[2]; /* whether a timeline and a preset were chosen since the project was opened */
    int note;
    double finger; /* the note's place, 0 to 1 */
    int is_playing; /* the host's transport */
    int64_t song; /* its frame at this block's frame 0, from the start of the project */
    int following; /* the transport touches */
    int64_t followed; /* the frame of the song after the last one that was followed */
    double place; /* the transport's, 0 to 1 */
    int owed_hands, owed_parameters; /* what found no room in a queue */
    int32_t done; /* frames of this block that are rendered */
    float *click, *tactor;
    float block[2 * VOICE_CHUNK], before[2 * VOICE_CHUNK];
} voice;

static inline double voice_lowest(int which) {
    return which < VOICE_OWN ? 0.0 : overview_parameters[which - VOICE_OWN].lowest;
}
static inline double voice_highest(const voice *v, int which) {
    if (which == VOICE_TIMELINE) return bundle_timelines_count - 1;
    if (which == VOICE_PRESET) return v->count - 1;
    return which < VOICE_OWN ? 1.0 : overview_parameters[which - VOICE_OWN].highest;
}
static inline int voice_is_choice(int which) {
    if (which < VOICE_OWN) return which != VOICE_THETA2;
    return bundle_labels[which - VOICE_OWN].choices != NULL;
}
/* Whether it says which image plays. */
static inline int voice_chooses(int which) { return which == VOICE_TIMELINE || which == VOICE_PRESET; }
static inline const bundle_preset *voice_preset(const voice *v, int which) {
    return &bundle_presets[v->first + which];
}
static inline const bundle_image *voice_image(const voice *v, double timeline, double preset) {
    return &bundle_images[(int)timeline * bundle_presets_count + v->first + (int)preset];
}
static inline double voice_default(const voice *v, int which) {
    return which < VOICE_OWN ? 0.0 : voice_preset(v, 0)->values[which - VOICE_OWN];
}

static void voice_init(voice *v, int first, int count) {
    int i;
    memset(v, 0, sizeof *v);
    v->first = first, v->count = count, v->note = VOICE_NO_NOTE;
    for (i = 0; i < VOICE_VALUES; i++) {
        v->applied[i] = voice_default(v, i);
        atomic_init(&v->values[i], v->applied[i]);
    }
}

static void voice_deactivate(voice *v) {
    int i;
    for (i = 0; i < 2; i++) free(v->memories[i]), v->memories[i] = NULL, v->loaded[i] = NULL;
}

/* From one column of a map to the other, as `AngleMap`; of equal times the last one counts. */
enum { VOICE_TIME, VOICE_PLACE };
static double voice_mapped(const bundle_image *image, int from, double at) {
    const double *low, *high;
    double width;
    int i = 0;
    while (i < image->points - 2 && image->map[i + 1][from] <= at) i++;
    low = image->map[i], high = image->map[i + 1];
    width = high[from] - low[from];
    return low[!from] + (width > 0.0 ? (at - low[from]) / width : 0.0) * (high[!from] - low[!from]);
}

static inline int voice_active(const voice *v) { return v->memories[1] != NULL; }
static inline void *voice_memory(const voice *v) { return v->memories[v->current]; }

static void voice_hand(voice *v, int source, int32_t at);

/* The image of the moment as new, with the values of the moment and whoever touches; or why not, as of
   overview_load. */
static int32_t voice_start(voice *v) {
    void *memory = voice_memory(v);
    const bundle_image *image = voice_image(v, v->applied[VOICE_TIMELINE], v->applied[VOICE_PRESET]);
    int32_t refused;
    if (v->loaded[v->current] != image) {
        v->loaded[v->current] = NULL;
        if ((refused = overview_load(memory, bundle_data + image->at, image->bytes))) return refused;
        v->loaded[v->current] = image;
    }
    memcpy((char *)memory + 8 * OVERVIEW_PARAMETER, v->applied + VOICE_OWN, 8 * OVERVIEW_PARAMETERS);
    if (overview_prepare(memory, v->rate)) {
        /* the carrier is too high for this rate: its own may do */
        int at = OVERVIEW_PARAMETER + OVERVIEW_TACTOR_FREQUENCY_HZ;
        const double *own = voice_preset(v, (int)v->applied[VOICE_PRESET])->values;
        memcpy((char *)memory + 8 * at, own + OVERVIEW_TACTOR_FREQUENCY_HZ, 8);
        if (overview_prepare(memory, v->rate)) return OVERVIEW_REFUSED;
    }
    v->owed_hands = v->owed_parameters = 0;
    if (v->applied[VOICE_TOUCH] > 0.0) voice_hand(v, OVERVIEW_TOUCH, VOICE_AT_ONCE);
    if (v->note != VOICE_NO_NOTE) voice_hand(v, OVERVIEW_MIDI, VOICE_AT_ONCE);
    v->following = 0; /* the transport touches again in the next frame, at its place in this image */
    return OVERVIEW_DONE;
}

static int32_t voice_restart(voice *v) {
    int i;
    atomic_store(&v->restored, 0);
    for (i = 0; i < VOICE_VALUES; i++) v->applied[i] = atomic_load(&v->values[i]);
    v->fade_left = v->waits = 0;
    v->note = VOICE_NO_NOTE;
    return voice_start(v);
}

/* While it is active, too: anew, at another rate. */
static int32_t voice_activate(voice *v, double rate) {
    int32_t refused = OVERVIEW_REFUSED;
    int i;
    voice_deactivate(v);
    v->rate = rate;
    for (i = 0; i < 2; i++) v->memories[i] = calloc(1, (size_t)OVERVIEW_MEMORY_BYTES);
    if (v->memories[0] && v->memories[1] && !(refused = voice_restart(v))) {
        v->fade = (int64_t)(voice_fade_s * rate) + 1;
        /* the system finds the pages now, not at the first switch */
        memset(v->memories[!v->current], 0, (size_t)OVERVIEW_MEMORY_BYTES);
        return OVERVIEW_DONE;
    }
    voice_deactivate(v);
    return refused;
}

/* Tell again, as soon as possible, what found no room. */
static void voice_pay(voice *v) {
    int source, owed = v->owed_hands;
    v->owed_hands = 0;
    for (source = 0; owed >> source; source++)
        if (owed >> source & 1) voice_hand(v, source, VOICE_AT_ONCE);
    if (v->owed_parameters) {
        /* the memory has the values already: any change pushes them all */
        double first = overview_number(voice_memory(v), OVERVIEW_PARAMETER);
        v->owed_parameters = overview_change(voice_memory(v), 0, first, OVERVIEW_AT_ONCE) != 0;
    }
}

static void voice_switch(voice *v, int32_t at);

/* Where the host's transport is from frame `at` of the block on. */
static void voice_transport(voice *v, double seconds, int is_playing, int32_t at) {
    double frames = seconds * v->rate;
    v->is_playing = is_playing && frames > -1e15 && frames < 1e15;
    if (frames > -1e15 && frames < 1e15) v->song = (int64_t)(frames < 0.0 ? frames - 0.5 : frames + 0.5) - at;
}
/* The transport touches the timeline at its own time, in the next `frames` frames: at multiples of a
   step, so that blocks do not matter, and at once after a jump. */
static void voice_follow(voice *v, int32_t frames) {
    const bundle_image *image = v->loaded[v->current]; /* that of the values may wait for a fade */
    int64_t step = (int64_t)(voice_follow_s * v->rate + 0.5), first = v->song + v->done, at;
    int follows = image && v->applied[VOICE_FOLLOW] > 0.0 && v->is_playing;
    for (at = first; at < first + frames; at++) {
        double time = (double)at / v->rate;
        int within = follows && time >= 0.0 && time <= image->map[image->points - 1][VOICE_TIME];
        int changes = within != v->following || (within && (at % step == 0 || at != v->followed));
        v->followed = at + 1;
        if (!changes) continue;
        if (within) v->place = voice_mapped(image, VOICE_TIME, time);
        v->following = within;
        voice_hand(v, OVERVIEW_REMOTE, (int32_t)(at - v->song));
    }
}

/* Render the block's frames below `until`. */
static void voice_run(voice *v, int32_t until) {
    while (v->done < until) {
        int32_t i, n = until - v->done < VOICE_CHUNK ? until - v->done : VOICE_CHUNK;
        if (v->fade_left > 0 && v->fade_left < n) n = (int32_t)v->fade_left;
        if (v->following || (v->applied[VOICE_FOLLOW] > 0.0 && v->is_playing)) voice_follow(v, n);
        overview_process(voice_memory(v), v->block, n, 2);
        if (v->fade_left > 0) {
            overview_process(v->memories[!v->current], v->before, n, 2);
            for (i = 0; i < n; i++, v->fade_left--) {
                double part = (double)v->fade_left / (double)v->fade;
                float *to = v->block + 2 * i, *from = v->before + 2 * i;
                to[0] = (float)((double)to[0] + ((double)from[0] - (double)to[0]) * part);
                to[1] = (float)((double)to[1] + ((double)from[1] - (double)to[1]) * part);
            }
        }
        for (i = 0; i < n; i++) {
            if (v->click) v->click[v->done + i] = v->block[2 * i];
            if (v->tactor) v->tactor[v->done + i] = v->block[2 * i + 1];
        }
        v->done += n;
        if (v->waits && v->fade_left == 0) voice_switch(v, v->done);
        if (v->owed_hands || v->owed_parameters) voice_pay(v);
    }
}

static int64_t voice_stamp(const voice *v, int32_t at) {
    if (at < v->done) return OVERVIEW_AT_ONCE;
    return overview_count(voice_memory(v), OVERVIEW_CLOCK) + (at - v->done);
}

/* Tell the memory where a source's finger is, from frame `at` of the block on. */
static void voice_hand(voice *v, int source, int32_t at) {
    int midi = source == OVERVIEW_MIDI, song = source == OVERVIEW_REMOTE;
    double place = song ? v->place : midi ? v->finger : v->applied[VOICE_THETA2];
    int held = song ? v->following : midi ? v->note != VOICE_NO_NOTE : v->applied[VOICE_TOUCH] > 0.0;
    int tries;
    for (tries = 0; tries < 2; tries++) {
        if (!overview_control(voice_memory(v), source, voice_stamp(v, at), voice_pi * place, held)) return;
        if (at > v->done && !song) voice_run(v, at); /* the song's are of frames that run next */
    }
    v->owed_hands |= 1 << source;
}

static void voice_change(voice *v, int parameter, double value, int32_t at) {
    int tries;
    if (v->waits) return; /* the image that waits begins with it */
    for (tries = 0; tries < 2; tries++) {
        if (!overview_change(voice_memory(v), parameter, value, voice_stamp(v, at))) return;
        if (at > v->done) voice_run(v, at);
    }
    v->owed_parameters = 1;
}

/* Another image from frame `at` on: it begins anew, and the one before fades out, as it is held. One
   that comes while another fades in waits for it. A damaged one is not switched to. */
static void voice_switch(voice *v, int32_t at) {
    if (at > v->done) voice_run(v, at);
    v->waits = v->fade_left > 0;
    if (v->waits) return;
    v->current = !v->current;
    if (voice_start(v)) v->current = !v->current;
    else v->fade_left = v->fade;
}

/* The value in its range that is nearest; a choice for a choice. */
static inline double voice_within(const voice *v, int which, double value) {
    if (value < voice_lowest(which)) value = voice_lowest(which);
    if (value > voice_highest(v, which)) value = voice_highest(v, which);
    return voice_is_choice(which) ? (double)(int)(value + 0.5) : value;
}

/* Keep a value, within its range, and tell no memory; NaN is no value. A preset comes with its own
   values. Whether there is something to tell. */
static int voice_keep(voice *v, int which, double value) {
    int i;
    if (value != value) return 0;
    value = voice_within(v, which, value);
    if (voice_chooses(which) && value == v->applied[which]) return 0;
    v->applied[which] = value;
    atomic_store(&v->values[which], value);
    if (voice_chooses(which)) atomic_store(&v->chosen[which - VOICE_TIMELINE], 1);
    if (which == VOICE_PRESET)
        for (i = VOICE_OWN; i < VOICE_VALUES; i++) {
            v->applied[i] = voice_preset(v, (int)value)->values[i - VOICE_OWN];
            atomic_store(&v->values[i], v->applied[i]);
        }
    return 1;
}

/* Before what is heard at frame `at`: an image that waits may begin until then. */
static void voice_reach(voice *v, int32_t at) {
    if (v->waits && at > v->done) voice_run(v, at);
}

/* A value from frame `at` of the block on; the memory is told while active. */
static void voice_set(voice *v, int which, double value, int32_t at) {
    voice_reach(v, at);
    if (which == VOICE_FOLLOW && voice_active(v)) voice_run(v, at); /* until here as before */
    if (!voice_keep(v, which, value) || !voice_active(v)) return;
    if (voice_chooses(which)) voice_switch(v, at);
    else if (which == VOICE_FOLLOW) return;
    else if (which < VOICE_OWN) voice_hand(v, OVERVIEW_TOUCH, at);
    else voice_change(v, which - VOICE_OWN, v->applied[which], at);
}

/* A key taps its place on the timeline, the lowest at the start; the last one pressed holds. */
static void voice_press(voice *v, int key, int32_t at) {
    voice_reach(v, at);
    v->note = key, v->finger = key / 127.0;
    if (voice_active(v)) voice_hand(v, OVERVIEW_MIDI, at);
}

/* A key, or any (-1), lets go. */
static void voice_release(voice *v, int key, int32_t at) {
    if (v->note == VOICE_NO_NOTE || (key >= 0 && key != v->note)) return;
    voice_reach(v, at);
    v->note = VOICE_NO_NOTE;
    if (voice_active(v)) voice_hand(v, OVERVIEW_MIDI, at);
}

/* MIDI's own messages; the modulation wheel moves the finger that holds. Whether theta2 moved. */
static int voice_midi(voice *v, const uint8_t *data, int32_t at) {
    int kind = data[0] & 0xF0, number = data[1] & 0x7F, value = data[2] & 0x7F;
    if (kind == 0x90 && value > 0) voice_press(v, number, at);
    else if (kind == 0x80 || kind == 0x90) voice_release(v, number, at);
    else if (kind == 0xB0 && (number == 120 || number == 123)) voice_release(v, -1, at);
    else if (kind == 0xB0 && number == 1) {
        if (v->note == VOICE_NO_NOTE) {
            voice_set(v, VOICE_THETA2, value / 127.0, at);
            return 1;
        }
        voice_reach(v, at);
        v->finger = value / 127.0;
        if (voice_active(v)) voice_hand(v, OVERVIEW_MIDI, at);
    }
    return 0;
}

/* A block begins, into these outputs (either may be NULL), with what was restored meanwhile. */
static void voice_begin(voice *v, float *click, float *tactor) {
    double now[VOICE_VALUES];
    int i;
    v->done = 0, v->click = click, v->tactor = tactor;
    if (!atomic_exchange(&v->restored, 0)) return;
    for (i = 0; i < VOICE_VALUES; i++) now[i] = atomic_load(&v->values[i]);
    if (now[VOICE_PRESET] != v->applied[VOICE_PRESET] || now[VOICE_TIMELINE] != v->applied[VOICE_TIMELINE]) {
        memcpy(v->applied, now, sizeof now);
        voice_switch(v, VOICE_AT_ONCE);
        return;
    }
    for (i = 0; i < VOICE_VALUES; i++)
        if (now[i] != v->applied[i]) voice_set(v, i, now[i], VOICE_AT_ONCE);
}

/* Whether it stays silent until the next event, which no start of the transport is. */
static inline int voice_asleep(const voice *v) {
    const void *memory = voice_memory(v);
    int64_t silence = (int64_t)(voice_silence_s * v->rate);
    return v->fade_left == 0 && v->note == VOICE_NO_NOTE && v->applied[VOICE_TOUCH] == 0.0
        && v->applied[VOICE_FOLLOW] == 0.0 && !v->following
        && overview_count(memory, OVERVIEW_M_SILENT) > silence
        && overview_count(memory, OVERVIEW_M_STILL) > silence;
}

/* Frames from the last release to silence; -1 where values were changed that it depends on. */
static inline int64_t voice_tail(voice *v) {
    double now[VOICE_VALUES], tail, rate;
    const bundle_preset *preset;
    const bundle_image *image;
    int i;
    for (i = 0; i < VOICE_VALUES; i++) now[i] = atomic_load(&v->values[i]);
    preset = voice_preset(v, (int)now[VOICE_PRESET]);
    for (i = 0; i < OVERVIEW_PARAMETERS; i++)
        if (i != OVERVIEW_TACTOR_MUTE && i != OVERVIEW_CLICK_MUTE && now[VOICE_OWN + i] != preset->values[i])
            return -1;
    image = voice_image(v, now[VOICE_TIMELINE], now[VOICE_PRESET]);
    tail = image->tail;
    for (rate = 48000.0; rate < v->rate; rate *= 2.0) tail += image->tail_per_octave;
    return (int64_t)(tail * v->rate) + 1;
}

#endif
