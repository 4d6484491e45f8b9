/* What a project keeps of a voice: the magic and version, the image's digest, then a row of id and
   value each. The image says which timeline and preset it is. */
#ifndef OVERVIEW_STATE_H
#define OVERVIEW_STATE_H
#include "values.h"

enum { STATE_ID = 32, STATE_HEAD = 8 + 2 * BUNDLE_DIGEST, STATE_ROW = STATE_ID + 8 };
enum { STATE_BYTES = STATE_HEAD + (VOICE_VALUES - 2) * STATE_ROW };
static const char state_magic[8] = {'O', 'V', 'D', 'S', 'P', 0, 0, 1}; /* its end is the version */

static void state_write(voice *v, char bytes[STATE_BYTES]) {
    char *row = bytes + STATE_HEAD;
    double values[VOICE_VALUES];
    int which;
    for (which = 0; which < VOICE_VALUES; which++) values[which] = atomic_load(&v->values[which]);
    memset(bytes, 0, STATE_BYTES);
    memcpy(bytes, state_magic, 8);
    memcpy(bytes + 8, voice_image(v, values[VOICE_TIMELINE], values[VOICE_PRESET])->digest, 2 * BUNDLE_DIGEST);
    for (which = 0; which < VOICE_VALUES; which++) {
        if (voice_chooses(which)) continue;
        strncpy(row, value_id(which), STATE_ID - 1);
        memcpy(row + STATE_ID, &values[which], 8);
        row += STATE_ROW;
    }
}

/* Whether the bytes are a state of this bundle: then, not before, `values` are all of its own. */
static int state_read(const voice *v, const char *bytes, size_t size, double values[VOICE_VALUES]) {
    const char *row = bytes + STATE_HEAD;
    int which, timeline, preset, found = 0;
    if (size != STATE_BYTES || memcmp(bytes, state_magic, 8)) return 0;
    for (timeline = 0; timeline < bundle_timelines_count; timeline++)
        for (preset = 0; preset < v->count && !found; preset++)
            if (!memcmp(bytes + 8, voice_image(v, timeline, preset)->digest, 2 * BUNDLE_DIGEST)) {
                values[VOICE_TIMELINE] = timeline, values[VOICE_PRESET] = preset;
                found = 1;
            }
    for (which = 0; found && which < VOICE_VALUES; which++) {
        char id[STATE_ID] = {0};
        double value;
        if (voice_chooses(which)) continue;
        strncpy(id, value_id(which), STATE_ID - 1);
        memcpy(&value, row + STATE_ID, 8);
        found = !memcmp(id, row, STATE_ID) && value >= voice_lowest(which) && value <= voice_highest(v, which)
            && (!voice_is_choice(which) || value == (int)value);
        values[which] = value;
        row += STATE_ROW;
    }
    return found; /* of other data, or another preset: no state of this bundle */
}

/* The voice begins with it, or hears of it at its next block. */
static void state_take(voice *v, const double values[VOICE_VALUES]) {
    int which;
    for (which = 0; which < VOICE_VALUES; which++) {
        atomic_store(&v->values[which], values[which]);
        if (!voice_active(v)) v->applied[which] = values[which];
    }
    atomic_store(&v->restored, 1);
}

#endif
