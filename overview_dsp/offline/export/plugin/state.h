/* What a project keeps of a voice: magic and version; the names of timeline and preset; the count of
   values; then a row of id and value for each, in any order. A build takes the rows whose ids it knows,
   and the preset's own values where a row is missing.

   Version 1 has a digest of the image in place of the names, and no count. */
#ifndef OVERVIEW_STATE_H
#define OVERVIEW_STATE_H
#include "values.h"

enum { STATE_ID = 32, STATE_ROW = STATE_ID + 8, STATE_MOST_ROWS = 256 };
enum { STATE_NAMES = 8, STATE_COUNT = STATE_NAMES + 2 * VOICE_NAME, STATE_HEAD = STATE_COUNT + 8 };
enum { STATE_HEAD_1 = 8 + 2 * BUNDLE_DIGEST };
enum { STATE_BYTES = STATE_HEAD + (VOICE_VALUES - 2) * STATE_ROW };
enum { STATE_MOST = STATE_HEAD + STATE_MOST_ROWS * STATE_ROW };
static const char state_magic[8] = {'O', 'V', 'D', 'S', 'P', 0, 0, 2}; /* its end is the version */

typedef struct {
    double values[VOICE_VALUES];
    char missing[2][VOICE_NAME]; /* names of a timeline and a preset that the bundle lacks, or empty */
    int unnamed[2]; /* whether the state has no name of them */
} state_values;

static void state_write(voice *v, char bytes[STATE_BYTES]) {
    char *row = bytes + STATE_HEAD;
    int64_t count = VOICE_VALUES - 2;
    int which;
    memset(bytes, 0, STATE_BYTES);
    memcpy(bytes, state_magic, 8), memcpy(bytes + STATE_COUNT, &count, 8);
    for (which = 0; which < VOICE_VALUES; which++) {
        double value = atomic_load(&v->values[which]);
        if (voice_chooses(which)) {
            const char *missing = value_missing(v, which, (int)value);
            char *name = bytes + STATE_NAMES + (which - VOICE_TIMELINE) * VOICE_NAME;
            strncpy(name, missing && *missing ? missing : value_choice(v, which, (int)value), VOICE_NAME - 1);
            continue;
        }
        strncpy(row, value_id(which), STATE_ID - 1);
        memcpy(row + STATE_ID, &value, 8);
        row += STATE_ROW;
    }
}

static double state_number(const char *row) {
    double value;
    memcpy(&value, row + STATE_ID, 8);
    return value;
}
/* Which value a row has; -1: one that this build does not know. */
static int state_which(const char *row) {
    static const struct { const char *id; int which; } earlier[] = {
        {"disk.catch_up", VOICE_OWN + OVERVIEW_CLUTCH_MAX_SPEED_RATIO},
        {"disk.unfold_s", VOICE_OWN + OVERVIEW_CLUTCH_TAP_DURATION_S},
    };
    int i;
    for (i = 0; i < VOICE_VALUES; i++)
        if (!voice_chooses(i) && !strncmp(value_id(i), row, STATE_ID)) return i;
    for (i = 0; i < 2; i++)
        if (!strncmp(earlier[i].id, row, STATE_ID)) return earlier[i].which;
    return -1;
}
/* The preset most of whose values are those of the rows. */
static int state_nearest(const voice *v, const char *rows, size_t count) {
    int preset, best = 0, most = -1;
    for (preset = 0; preset < v->count; preset++) {
        int equal = 0;
        size_t i;
        for (i = 0; i < count; i++) {
            int which = state_which(rows + i * STATE_ROW);
            equal += which >= VOICE_OWN
                && state_number(rows + i * STATE_ROW) == voice_preset(v, preset)->values[which - VOICE_OWN];
        }
        if (equal > most) most = equal, best = preset;
    }
    return best;
}
/* Timeline and preset: by their names, or in version 1 by the digest of their image. */
static void state_choose(const voice *v, const char *bytes, const char *rows, size_t count, state_values *s) {
    int which, timeline, preset, is_named = bytes[7] > 1;
    memset(s->missing, 0, sizeof s->missing), memset(s->unnamed, 0, sizeof s->unnamed);
    s->values[VOICE_TIMELINE] = 0.0, s->values[VOICE_PRESET] = state_nearest(v, rows, count);
    for (timeline = 0; timeline < bundle_timelines_count && !is_named; timeline++)
        for (preset = 0; preset < v->count; preset++)
            if (!memcmp(bytes + 8, voice_image(v, timeline, preset)->digest, 2 * BUNDLE_DIGEST)) {
                s->values[VOICE_TIMELINE] = timeline, s->values[VOICE_PRESET] = preset;
                return;
            }
    for (which = VOICE_TIMELINE; which <= VOICE_PRESET; which++) {
        const char *name = bytes + STATE_NAMES + (which - VOICE_TIMELINE) * VOICE_NAME;
        char *missing = s->missing[which - VOICE_TIMELINE];
        int choice = (int)voice_highest(v, which);
        if (!is_named) {
            /* a bundle of one has nothing else that was meant */
            s->unnamed[which - VOICE_TIMELINE] = choice > 0;
            continue;
        }
        while (choice >= 0 && strncmp(value_choice(v, which, choice), name, VOICE_NAME - 1)) choice--;
        if (choice < 0) memcpy(missing, name, VOICE_NAME - 1);
        else s->values[which] = choice;
    }
}
/* Whether the bytes are a state, of this build or another one; else `s` is undefined. */
static int state_read(const voice *v, const char *bytes, size_t size, state_values *s) {
    const char *rows;
    size_t count, i;
    double *tap_s = &s->values[VOICE_OWN + OVERVIEW_CLUTCH_TAP_DURATION_S];
    int which;
    if (size < STATE_HEAD_1 || memcmp(bytes, state_magic, 7) || bytes[7] < 1 || bytes[7] > state_magic[7]) return 0;
    if (bytes[7] > 1 && size < STATE_HEAD) return 0;
    rows = bytes + (bytes[7] > 1 ? STATE_HEAD : STATE_HEAD_1);
    count = (size - (size_t)(rows - bytes)) / STATE_ROW;
    if ((size_t)(rows - bytes) + count * STATE_ROW != size) return 0;
    if (bytes[7] > 1) {
        int64_t written;
        memcpy(&written, bytes + STATE_COUNT, 8);
        if (written != (int64_t)count) return 0;
    }
    for (which = 0; which < VOICE_OWN; which++) s->values[which] = voice_default(v, which);
    state_choose(v, bytes, rows, count, s);
    for (which = VOICE_OWN; which < VOICE_VALUES; which++)
        s->values[which] = voice_preset(v, (int)s->values[VOICE_PRESET])->values[which - VOICE_OWN];
    for (i = 0; i < count; i++) {
        double value = state_number(rows + i * STATE_ROW);
        if ((which = state_which(rows + i * STATE_ROW)) < 0) continue;
        if (!(value - value == 0.0)) return 0; /* no number */
        s->values[which] = voice_within(v, which, value);
    }
    for (i = 0; i < count; i++)
        if (!strncmp("disk.unfold_s", rows + i * STATE_ROW, STATE_ID)) {
            /* the time of a tap was that of the disk times the ratio */
            double ratio = s->values[VOICE_OWN + OVERVIEW_CLUTCH_MAX_SPEED_RATIO];
            *tap_s = state_number(rows + i * STATE_ROW) / (ratio > 0.0 ? ratio : 1.0);
            *tap_s = voice_within(v, VOICE_OWN + OVERVIEW_CLUTCH_TAP_DURATION_S, *tap_s);
        }
    return 1;
}

/* The voice begins with it, or hears of it at its next block. Thread: main. */
static void state_take(voice *v, const state_values *s) {
    int which;
    memcpy(v->missing, s->missing, sizeof v->missing), memcpy(v->unnamed, s->unnamed, sizeof v->unnamed);
    for (which = 0; which < VOICE_VALUES; which++) {
        if (voice_chooses(which)) {
            v->in_place[which - VOICE_TIMELINE] = (int)s->values[which];
            atomic_store(&v->chosen[which - VOICE_TIMELINE], 0);
        }
        atomic_store(&v->values[which], s->values[which]);
        if (!voice_active(v)) v->applied[which] = s->values[which];
    }
    atomic_store(&v->restored, 1);
}

#endif
