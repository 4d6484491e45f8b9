/* A hand sweeps over a timeline in four seconds and lets go: `example IMAGE OUT.wav [SAMPLE_RATE]`.
   The WAV file has 32-bit floats, clicks on the left, the tactor's vibration on the right. */
#include "overview.h"

#include <stdio.h>
#include <stdlib.h>

#define BLOCK 256
#define SECONDS 6
#define SWEEP_SECONDS 4
#define EVENTS_A_SECOND 100

static const double pi = 3.141592653589793;

static void *content(const char *path, long *bytes) {
    FILE *file = fopen(path, "rb");
    void *data = NULL;
    if (!file) return NULL;
    if (!fseek(file, 0, SEEK_END) && (*bytes = ftell(file)) > 0 && !fseek(file, 0, SEEK_SET)) {
        data = malloc((size_t)*bytes);
        if (data && fread(data, 1, (size_t)*bytes, file) != (size_t)*bytes) *bytes = 0;
    }
    fclose(file);
    return data;
}

static void put(FILE *file, uint32_t number, int bytes) {
    while (bytes--) fputc((int)(number & 255), file), number >>= 8;
}

static void wav_head(FILE *file, uint32_t rate, uint32_t frames) {
    fputs("RIFF", file), put(file, 36 + 8 * frames, 4), fputs("WAVEfmt ", file), put(file, 16, 4);
    put(file, 3, 2), put(file, 2, 2), put(file, rate, 4), put(file, 8 * rate, 4);
    put(file, 8, 2), put(file, 32, 2), fputs("data", file), put(file, 8 * frames, 4);
}

int main(int count, char **arguments) {
    uint32_t rate = count > 3 ? (uint32_t)atoi(arguments[3]) : 48000, frames = SECONDS * rate;
    long bytes = 0;
    void *image = count > 2 ? content(arguments[1], &bytes) : NULL;
    void *voice = calloc(1, (size_t)OVERVIEW_MEMORY_BYTES);
    FILE *out;
    float block[2 * BLOCK];
    uint32_t done, n;
    int32_t result;
    int event, events = SWEEP_SECONDS * EVENTS_A_SECOND;
    if (count < 3) return fputs("example IMAGE OUT.wav [SAMPLE_RATE]\n", stderr), 2;
    if (!image || !voice) return perror(image ? "memory" : arguments[1]), 1;
    result = overview_load(voice, image, bytes);
    if (!result) result = overview_prepare(voice, rate);
    if (result) return fprintf(stderr, "%s\n", overview_message(result)), 2;
    for (event = 0; event <= events; event++) /* a program would push each as it comes */
        overview_control(voice, OVERVIEW_TOUCH, (int64_t)event * rate / EVENTS_A_SECOND,
                         pi * event / events, event < events);
    if (!(out = fopen(arguments[2], "wb"))) return perror(arguments[2]), 1;
    wav_head(out, rate, frames);
    for (done = 0; done < frames; done += BLOCK) {
        n = frames - done < BLOCK ? frames - done : BLOCK;
        overview_process(voice, block, n, 2);
        fwrite(block, sizeof *block, 2 * n, out);
    }
    printf("%lld events struck\n", (long long)overview_count(voice, OVERVIEW_M_STRIKES));
    return fclose(out);
}
