/* Plays events in a voice: `c_runner IMAGE RATE BLOCK FRAMES EVENTS OUT`; EVENTS and OUT are raw.
   An event is six columns of 8 bytes: kind (0 hand, 1 parameter), source or parameter, sample,
   touching, value, and when to push it: before the block that holds that frame. */
#include "overview.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct { int64_t kind, which, sample, touching; double value; int64_t at; } event;

static void *content(const char *path, long *bytes) {
    FILE *file = fopen(path, "rb");
    void *data;
    if (!file) exit(3);
    fseek(file, 0, SEEK_END), *bytes = ftell(file), rewind(file);
    data = malloc((size_t)*bytes + 1);
    if (fread(data, 1, (size_t)*bytes, file) != (size_t)*bytes) exit(3);
    fclose(file);
    return data;
}

int main(int count, char **given) {
    long image_bytes, event_bytes;
    void *image, *voice = calloc(1, (size_t)OVERVIEW_MEMORY_BYTES);
    event *events;
    float *out;
    FILE *file;
    int64_t block, frames, done, n, next = 0, pushed;
    int32_t refused;
    if (count < 7) return 3;
    image = content(given[1], &image_bytes);
    events = (event *)content(given[5], &event_bytes);
    block = atol(given[3]), frames = atol(given[4]);
    out = (float *)calloc((size_t)(2 * block), sizeof *out);
    refused = overview_load(voice, image, image_bytes);
    if (refused) return fprintf(stderr, "%s\n", overview_message(refused)), 4;
    if (overview_prepare(voice, atof(given[2]))) return 5;
    file = fopen(given[6], "wb");
    for (done = 0; done < frames; done += n) {
        n = frames - done < block ? frames - done : block;
        for (; next < (int64_t)(event_bytes / sizeof *events) && events[next].at < done + n; next++) {
            event *e = events + next;
            pushed = e->kind == 0
                ? overview_control(voice, (int32_t)e->which, e->sample, e->value, (int32_t)e->touching)
                : overview_change(voice, (int32_t)e->which, e->value, e->sample);
            if (pushed) return 6;
        }
        if (overview_process(voice, out, n, 2)) return 7;
        fwrite(out, sizeof *out, (size_t)(2 * n), file);
    }
    return fclose(file);
}
