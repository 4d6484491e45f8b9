/* Three threads on one voice, as overview.h allows: `races IMAGE`; for ThreadSanitizer. */
#include "overview.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#define ROUNDS 400

static void *voice;

static void *hand(void *none) {
    int i;
    for (i = 0; i < 4 * ROUNDS; i++)
        overview_control(voice, OVERVIEW_TOUCH, OVERVIEW_AT_ONCE, 3.0 * (i % 97) / 97, i % 31 > 3);
    return none;
}

static void *changes(void *none) {
    int i;
    for (i = 0; i < ROUNDS; i++)
        overview_change(voice, OVERVIEW_TACTOR_GAIN_DB, -(i % 7), OVERVIEW_AT_ONCE);
    return none;
}

int main(int count, char **given) {
    static char image[1 << 22];
    float out[128];
    pthread_t threads[2];
    FILE *file = count > 1 ? fopen(given[1], "rb") : NULL;
    int i;
    if (!file) return 3;
    voice = calloc(1, (size_t)OVERVIEW_MEMORY_BYTES);
    if (overview_load(voice, image, (int64_t)fread(image, 1, sizeof image, file))) return 4;
    if (overview_prepare(voice, 48000.0)) return 5;
    pthread_create(threads, NULL, hand, NULL);
    pthread_create(threads + 1, NULL, changes, NULL);
    for (i = 0; i < ROUNDS; i++) overview_process(voice, out, 64, 2);
    for (i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    printf("%d strikes\n", (int)overview_count(voice, OVERVIEW_M_STRIKES));
    return fclose(file);
}
