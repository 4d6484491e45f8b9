/* What a host shows of a voice's values: ids, names, units, texts. */
#ifndef OVERVIEW_VALUES_H
#define OVERVIEW_VALUES_H
#include "voice.h"

#include <stdio.h>

/* Ids stay, whatever is added to the table. */
static const char *value_id(int which) {
    static const char *const hands[] = {"theta2", "touch", "timeline", "preset"};
    return which < VOICE_OWN ? hands[which] : overview_parameters[which - VOICE_OWN].id;
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

/* Without the unit; whether there is such a value. */
static int value_to_text(const voice *v, int which, double value, char *text, size_t size) {
    if (!(value >= voice_lowest(which) && value <= voice_highest(v, which))) return 0;
    if (voice_is_choice(which)) snprintf(text, size, "%s", value_choice(v, which, (int)(value + 0.5)));
    else snprintf(text, size, "%.9g", value);
    return 1;
}
static int value_from_text(const voice *v, int which, const char *text, double *value) {
    int choice;
    char *end;
    if (voice_is_choice(which))
        for (choice = 0; choice <= (int)voice_highest(v, which); choice++)
            if (!strcmp(text, value_choice(v, which, choice))) return *value = choice, 1;
    *value = strtod(text, &end);
    return end != text && *value >= voice_lowest(which) && *value <= voice_highest(v, which);
}

#endif
