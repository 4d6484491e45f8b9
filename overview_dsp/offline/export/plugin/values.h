/* What a host shows of a voice's values: ids, names, units, texts. */
#ifndef OVERVIEW_VALUES_H
#define OVERVIEW_VALUES_H
#include "voice.h"

#include <stdio.h>

/* Ids stay, whatever is added to the table or renamed in it. */
static const char *value_id(int which) {
    static const char *const hands[] = {"theta2", "touch", "timeline", "preset"};
    return which < VOICE_OWN ? hands[which] : bundle_labels[which - VOICE_OWN].id;
}
static uint32_t value_number(int which) {
    const char *id;
    uint32_t hash = 2166136261u; /* FNV-1a */
    for (id = value_id(which); *id; id++) hash = (hash ^ (uint8_t)*id) * 16777619u;
    return hash;
}
/* Which value has a number, as far as these bits of it; -1: none. */
static int value_of(uint32_t number, uint32_t bits) {
    int which;
    for (which = 0; which < VOICE_VALUES; which++)
        if ((value_number(which) & bits) == number) return which;
    return -1;
}
static const char *value_name(int which) {
    static const char *const names[] = {"Angle", "Touch", "Timeline", "Preset"};
    return which < VOICE_OWN ? names[which] : bundle_labels[which - VOICE_OWN].name;
}
static const char *value_unit(int which) {
    return which < VOICE_OWN ? "" : overview_parameters[which - VOICE_OWN].unit;
}
static const char *value_choice(const voice *v, int which, int choice) {
    static const char *const switched[] = {"off", "on"};
    if (which == VOICE_TIMELINE) return bundle_timelines[choice];
    if (which == VOICE_PRESET) return voice_preset(v, choice)->name;
    return which == VOICE_TOUCH ? switched[choice] : bundle_labels[which - VOICE_OWN].choices[choice];
}
/* Whether there is nothing to choose. */
static int value_is_hidden(const voice *v, int which) {
    return voice_chooses(which) && voice_highest(v, which) == 0.0;
}

/* ---- the moment at an angle */

enum { VALUE_TIME, VALUE_PLACE }; /* columns of the map */

static const bundle_image *value_image(voice *v) {
    double timeline = atomic_load(&v->values[VOICE_TIMELINE]);
    return voice_image(v, timeline, atomic_load(&v->values[VOICE_PRESET]));
}
/* From one column of a map to the other, as `AngleMap`; of equal times the last one counts. */
static double value_mapped(const bundle_image *image, int from, double at) {
    const double *low, *high;
    double width;
    int i = 0;
    while (i < image->points - 2 && image->map[i + 1][from] <= at) i++;
    low = image->map[i], high = image->map[i + 1];
    width = high[from] - low[from];
    return low[!from] + (width > 0.0 ? (at - low[from]) / width : 0.0) * (high[!from] - low[!from]);
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
    double time = value_mapped(value_image(v), VALUE_PLACE, place);
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
    if (parts < 2 || parts > 3 || *end || time > image->map[image->points - 1][VALUE_TIME]) return 0;
    *place = value_mapped(image, VALUE_TIME, time);
    return 1;
}

/* ---- texts */

/* Without the unit; whether there is such a value. */
static int value_to_text(voice *v, int which, double value, char *text, size_t size) {
    if (!(value >= voice_lowest(which) && value <= voice_highest(v, which))) return 0;
    if (voice_is_choice(which)) snprintf(text, size, "%s", value_choice(v, which, (int)(value + 0.5)));
    else {
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
        for (choice = 0; choice <= (int)voice_highest(v, which); choice++)
            if (!strcmp(text, value_choice(v, which, choice))) return *value = choice, 1;
    *value = strtod(text, &end);
    if (which == VOICE_THETA2 && *end == ':') return value_from_clock(v, text, value);
    return end != text && *value >= voice_lowest(which) && *value <= voice_highest(v, which);
}

#endif
