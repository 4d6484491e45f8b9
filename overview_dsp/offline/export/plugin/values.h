/* What a host shows of a voice's values: ids, names, units, texts. */
#ifndef OVERVIEW_VALUES_H
#define OVERVIEW_VALUES_H
#include "voice.h"

#include <math.h>
#include <stdio.h>

/* Ids stay, whatever is added to the table or renamed in it. */
static const char *value_id(int which) {
    static const char *const hands[] = {"theta2", "touch", "timeline", "preset", "follow"};
    return which < VOICE_OWN ? hands[which] : bundle_labels[which - VOICE_OWN].id;
}
static int value_is_log(int which) { return which >= VOICE_OWN && bundle_labels[which - VOICE_OWN].is_log; }
static uint32_t value_hash(const char *text, uint32_t hash) { /* FNV-1a */
    for (; *text; text++) hash = (hash ^ (uint8_t)*text) * 16777619u;
    return hash;
}
/* A logarithmic range has another number than the linear one of earlier builds, whose automation would
   mean other values on it. */
static uint32_t value_number(int which) {
    return value_hash(value_is_log(which) ? ".log" : "", value_hash(value_id(which), 2166136261u));
}
/* Which value has a number, as far as these bits of it; -1: none. */
static int value_of(uint32_t number, uint32_t bits) {
    int which;
    for (which = 0; which < VOICE_VALUES; which++)
        if ((value_number(which) & bits) == number) return which;
    return -1;
}
static const char *value_name(int which) {
    static const char *const names[] = {"Angle", "Touch", "Timeline", "Preset", "Follow transport"};
    return which < VOICE_OWN ? names[which] : bundle_labels[which - VOICE_OWN].name;
}
static const char *value_unit(int which) {
    return which < VOICE_OWN ? "" : overview_parameters[which - VOICE_OWN].unit;
}
static const char *value_choice(const voice *v, int which, int choice) {
    static const char *const switched[] = {"off", "on"};
    if (which == VOICE_TIMELINE) return bundle_timelines[choice];
    if (which == VOICE_PRESET) return voice_preset(v, choice)->name;
    return which < VOICE_OWN ? switched[choice] : bundle_labels[which - VOICE_OWN].choices[choice];
}
/* The name that a project has for this choice, where the bundle lacks it, until one is chosen; empty if
   the project has none; or NULL. */
static const char *value_missing(voice *v, int which, int choice) {
    int i = which - VOICE_TIMELINE;
    if (!voice_chooses(which) || atomic_load(&v->chosen[i])) return NULL;
    return (*v->missing[i] || v->unnamed[i]) && choice == v->in_place[i] ? v->missing[i] : NULL;
}
/* Whether there is nothing to choose. */
static int value_is_hidden(const voice *v, int which) {
    return voice_chooses(which) && voice_highest(v, which) == 0.0;
}

/* ---- numbers from 0 to 1 */

/* By square roots, one for each bit of the part: with every compiler the same bits. */
static double value_log_at(double low, double high, double part) {
    double ratio = high / low, value = low, bit = 0.5;
    if (part >= 1.0) return high;
    for (; bit > 1e-16; bit *= 0.5) {
        ratio = sqrt(ratio);
        if (part >= bit) part -= bit, value *= ratio;
    }
    return value < high ? value : high;
}
static double value_log_part(double low, double high, double value) {
    double ratio = high / low, rest = value / low, part = 0.0, bit = 0.5;
    if (value >= high) return 1.0;
    for (; bit > 1e-16; bit *= 0.5) {
        ratio = sqrt(ratio);
        if (rest >= ratio) rest /= ratio, part += bit;
    }
    return part;
}
static double value_normal(const voice *v, int which, double plain) {
    double low = voice_lowest(which), high = voice_highest(v, which);
    if (value_is_log(which)) return value_log_part(low, high, plain);
    return high > low ? (plain - low) / (high - low) : 0.0;
}
/* Whether a host says what it was told: some hold numbers as floats. */
static int value_is_told(double told, double said) {
    return told == said || (said == (double)(float)said && (float)told == (float)said);
}
/* `known`: values that keep all their bits on the way through a host, as the preset's own do. NaN stays. */
static double value_plain(const voice *v, int which, double normal, const double *known) {
    double low = voice_lowest(which), high = voice_highest(v, which);
    if (normal != normal) return normal;
    normal = normal < 0.0 ? 0.0 : normal > 1.0 ? 1.0 : normal;
    if (voice_is_choice(which)) {
        int choice = (int)(normal * (high + 1.0));
        return choice > (int)high ? high : choice;
    }
    if (value_is_told(value_normal(v, which, known[which]), normal)) return known[which];
    if (which >= VOICE_OWN) {
        double own = voice_preset(v, (int)known[VOICE_PRESET])->values[which - VOICE_OWN];
        if (value_is_told(value_normal(v, which, own), normal)) return own;
    }
    return value_is_log(which) ? value_log_at(low, high, normal) : low + normal * (high - low);
}

/* ---- the moment at an angle */

static const bundle_image *value_image(voice *v) {
    double timeline = atomic_load(&v->values[VOICE_TIMELINE]);
    return voice_image(v, timeline, atomic_load(&v->values[VOICE_PRESET]));
}
/* A date, as the timeline's calendar has it. */
static void value_date(double since_1970, char *text, size_t size) {
    /* seconds since the March 1st before the year 1, of a calendar that begins with March */
    int64_t at = (int64_t)(since_1970 + 62162035200.0 + 1e-6), day = at / 86400, rest = at % 86400;
    int64_t era = day / 146097, left = day % 146097;
    int64_t year = (left - left / 1460 + left / 36524 - left / 146096) / 365;
    int64_t month;
    left -= 365 * year + year / 4 - year / 100;
    month = (5 * left + 2) / 153;
    snprintf(text, size, "%04d-%02d-%02d %02d:%02d:%02d", (int)(400 * era + year + (month > 9)),
             (int)(month > 9 ? month - 9 : month + 3), (int)(left - (153 * month + 2) / 5 + 1),
             (int)(rest / 3600), (int)(rest / 60 % 60), (int)(rest % 60));
}
/* As `Timeline.moment_text`. */
static void value_moment(voice *v, double place, char *text, size_t size) {
    double start = bundle_starts[(int)atomic_load(&v->values[VOICE_TIMELINE])];
    double time = voice_mapped(value_image(v), VOICE_PLACE, place);
    int64_t tenths = (int64_t)(10.0 * time + 0.5), minutes = tenths / 600;
    if (start == start) value_date(start + time, text, size);
    else {
        if (minutes < 60) snprintf(text, size, "%d", (int)minutes);
        else snprintf(text, size, "%d:%02d", (int)(minutes / 60), (int)(minutes % 60));
        size -= strlen(text), text += strlen(text);
        snprintf(text, size, ":%02d.%d", (int)(tenths % 600 / 10), (int)(tenths % 10));
    }
}
/* The place of a clock time (m:ss, h:mm:ss) of the timeline; whether it is one. */
static int value_from_clock(voice *v, const char *text, double *place) {
    const bundle_image *image = value_image(v);
    double time = 0.0, part;
    char *end;
    int parts;
    if (strchr(text, '-')) return 0;
    for (parts = 1; parts <= 3; parts++, text = end + 1) {
        part = strtod(text, &end);
        if (end == text || !(part >= 0.0)) return 0;
        time = 60.0 * time + part;
        if (*end != ':') break;
    }
    if (parts < 2 || parts > 3 || *end || time > image->map[image->points - 1][VOICE_TIME]) return 0;
    *place = voice_mapped(image, VOICE_TIME, time);
    return 1;
}

/* ---- texts */

/* As much of a text as fits, in whole characters (UTF-8). */
static void value_copy(char *to, size_t size, const char *text) {
    size_t n = strlen(text);
    if (n >= size)
        for (n = size - 1; n > 0 && ((uint8_t)text[n] & 0xC0) == 0x80;) n--;
    memcpy(to, text, n), to[n] = 0;
}
/* Without the unit; whether there is such a value. */
static int value_to_text(voice *v, int which, double value, char *text, size_t size) {
    if (!(value >= voice_lowest(which) && value <= voice_highest(v, which))) return 0;
    if (voice_is_choice(which)) {
        const char *name = value_choice(v, which, (int)(value + 0.5));
        const char *missing = value_missing(v, which, (int)(value + 0.5));
        char shown[100], kept[100], both[256];
        if (missing) {
            value_copy(shown, sizeof shown, name), value_copy(kept, sizeof kept, missing);
            if (*missing) snprintf(both, sizeof both, "%s (in place of %s)", shown, kept);
            else snprintf(both, sizeof both, "%s (the project names no %s)", shown, value_id(which));
        }
        value_copy(text, size, missing ? both : name);
    } else {
        char moment[64];
        snprintf(text, size, "%.9g", value);
        if (which != VOICE_THETA2) return 1;
        value_moment(v, value, moment, sizeof moment);
        snprintf(text + strlen(text), size - strlen(text), " (%s)", moment);
    }
    return 1;
}
/* What follows a number doesn't count; an angle may be a clock time. */
static int value_from_text(voice *v, int which, const char *text, double *value) {
    int choice;
    char *end;
    if (voice_is_choice(which))
        for (choice = 0; choice <= (int)voice_highest(v, which); choice++) {
            char own[512];
            if (!strcmp(text, value_choice(v, which, choice))) return *value = choice, 1;
            if (value_to_text(v, which, choice, own, sizeof own) && !strcmp(text, own)) return *value = choice, 1;
        }
    *value = strtod(text, &end);
    if (which == VOICE_THETA2 && *end == ':') return value_from_clock(v, text, value);
    return end != text && *value >= voice_lowest(which) && *value <= voice_highest(v, which);
}

#endif
