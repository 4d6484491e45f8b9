/* What a plugin holds: bundle.c, which `overview plugin build` writes. */
#ifndef OVERVIEW_BUNDLE_H
#define OVERVIEW_BUNDLE_H
#include "overview.h"

#define BUNDLE_DIGEST 32 /* bytes */

typedef struct {
    const char *name;
    const char *uri; /* of its LV2 plugin */
    const char *digest; /* SHA-256 of the image */
    const char *image;
    int64_t bytes;
    double tail; /* s, from the last release to exact silence, with these values */
    double values[OVERVIEW_PARAMETERS]; /* the preset's own, in the table's order */
} bundle_preset;

typedef struct {
    const char *name, *section;
    const char *const *choices; /* NULL for a number; a choice's value is its index */
} bundle_label;

extern const char bundle_id[], bundle_name[], bundle_version[], bundle_description[];
extern const int bundle_presets_count;
extern const bundle_preset bundle_presets[];
extern const bundle_label bundle_labels[OVERVIEW_PARAMETERS];

#endif
