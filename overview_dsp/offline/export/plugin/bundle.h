/* What a plugin holds: bundle.c, which `overview plugin build` writes, with the images' bytes. */
#ifndef OVERVIEW_BUNDLE_H
#define OVERVIEW_BUNDLE_H
#include "overview.h"

#define BUNDLE_DIGEST 32 /* bytes */

typedef struct {
    const char *name;
    const char *uri; /* of its LV2 plugin */
    double values[OVERVIEW_PARAMETERS]; /* its own, in the table's order */
} bundle_preset;

typedef struct {
    const char *digest; /* SHA-256 of the image */
    int64_t at, bytes; /* in bundle_data */
    double tail; /* s, from the last release to exact silence, with the preset's own values, at 48 kHz */
    double tail_per_octave; /* s more for each octave above */
    const double (*map)[2]; /* times, s, and their positions, 0 to 1; linear in between */
    int points; /* of the map */
} bundle_image;

typedef struct {
    const char *id, *name, *section; /* the id that hosts keep, whatever is renamed */
    const char *const *choices; /* NULL for a number; a choice's value is its index */
    int is_log; /* whether its range is logarithmic */
} bundle_label;

extern const char bundle_id[], bundle_name[], bundle_version[];
extern const uint32_t bundle_class[4]; /* in VST3 */
extern const int bundle_presets_count, bundle_timelines_count;
extern const char *const bundle_timelines[];
extern const double bundle_starts[]; /* of the timelines: s since 1970 on their own clock, or NaN */
extern const bundle_preset bundle_presets[];
extern const bundle_image bundle_images[]; /* a timeline's in every preset, then the next one's */
extern const bundle_label bundle_labels[OVERVIEW_PARAMETERS];
extern const char bundle_data[];

#endif
