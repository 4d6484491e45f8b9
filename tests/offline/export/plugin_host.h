/* A plugin host for the tests, whatever the format. Every block is checked: each sample written, none
   beyond, all normal numbers, nothing allocated, and a second instance beside it that does the same.

   HOST PLUGIN list
   HOST PLUGIN play RATE BLOCK FRAMES EVENTS OUT STATE_IN STATE_OUT WARM
   HOST PLUGIN load STATE...           says 1 for each that is taken, 0 for each refused; then what is logged
   HOST PLUGIN texts STATE NUMBER TEXT...   the value of each text of a parameter, and its text again
   HOST PLUGIN probe                   calls every function with what it must refuse or bear

   PLUGIN: the library. BLOCK 0: of any size from 1 to 512. EVENTS: rows of kind (0 value, 1 key down,
   2 key up, 3 MIDI, 4 transport: 1 if it plays, and its seconds), number, frame, value; those at -1 come before it is active, those at -2 to -9
   after it is, without a block. STATE_*: a path or -; STATE_IN is loaded before it is active, with a
   + before it after. WARM: frames of the same events that are played before a reset. OUT: the two
   outputs' samples in turn. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "interposed.h"

#ifdef _WIN32
#include <windows.h>
static void *library_open(const char *path) { return (void *)LoadLibraryA(path); }
static void *library_find(void *library, const char *name) {
    return (void *)(uintptr_t)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *library_open(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *library_find(void *library, const char *name) { return dlsym(library, name); }
#endif
enum { LARGEST = 4096, GUARD = 16, MOST_EVENTS = 1 << 16 };
enum { KIND_VALUE, KIND_DOWN, KIND_UP, KIND_MIDI, KIND_TRANSPORT };
typedef struct { int64_t kind, number, frame; double value; } row;
typedef struct { const row *rows; int64_t count, first; } list;
typedef struct { char *bytes; size_t size, at; } memory_file;

static const double wild[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300, -1.0, -0.0, 0.0, 5e-324,
                              0.5, 1.0, 1.0000001, 2147483648.0, 4294967296.0, 9223372036854775808.0};
static const double wild_rates[] = {NAN, INFINITY, -INFINITY, -48000.0, 0.0, 5e-324, 999.9, 768001.0, 1e300};
#define EACH(i, of) (i = 0; i < sizeof of / sizeof *of; i++)

static void fail(const char *why) { fprintf(stderr, "%s\n", why), exit(3); }

static void *content(const char *path, size_t *bytes) {
    FILE *file = fopen(path, "rb");
    void *data;
    if (!file) fail(path);
    fseek(file, 0, SEEK_END), *bytes = (size_t)ftell(file), rewind(file);
    data = malloc(*bytes + 1);
    if (fread(data, 1, *bytes, file) != *bytes) fail(path);
    fclose(file);
    return data;
}
/* Streams that take and give a few bytes at a time. */
static int64_t written(memory_file *to, const void *data, uint64_t size) {
    uint64_t n = size < 7 ? size : 7;
    to->bytes = realloc(to->bytes, to->size + n);
    memcpy(to->bytes + to->size, data, n), to->size += n;
    return (int64_t)n;
}
static int64_t taken(memory_file *from, void *data, uint64_t size) {
    uint64_t n = size < 5 ? size : 5;
    if (n > from->size - from->at) n = from->size - from->at;
    memcpy(data, from->bytes + from->at, n), from->at += n;
    return (int64_t)n;
}

/* ---- what a format does; two instances */

static void host_open(void *library, const char *path);
static void host_list(void);
static bool host_text(unsigned number, const char *said, double *value, char text[256]);
static void host_probe(void);
static void host_flush(int i, const list *events);
static bool host_activate(int i, double rate);
static int host_process(int i, const list *events, int64_t frames, float *click, float *tactor); /* 4: silent */
static void host_reset(int i);
static bool host_load(int i, memory_file *from);
static bool host_save(int i, memory_file *to);
static void host_close(void);
static unsigned host_latency(void), host_tail(void);
static int64_t rounded(double x) { return (int64_t)(x < 0.0 ? x - 0.5 : x + 0.5); }
/* The host's transport: where it was at a frame, and whether it plays. */
static struct { bool is_known, is_playing; double seconds, rate; int64_t frame; } transport;
static void transport_hear(const list *events, int64_t last) {
    int64_t i;
    for (i = 0; i < events->count; i++) {
        const row *r = events->rows + i;
        if (r->kind != KIND_TRANSPORT || r->frame > last) continue;
        transport.is_known = true, transport.is_playing = r->number != 0;
        transport.seconds = r->value, transport.frame = r->frame;
    }
}
static double transport_seconds(int64_t frame) {
    return transport.seconds + (double)(transport.is_playing ? frame - transport.frame : 0) / transport.rate;
}
static int tail_changes, rescans;
static long told;
static char logged[4096]; /* lines */

static bool load(int i, const char *path) {
    memory_file file = {NULL, 0, 0};
    bool good;
    file.bytes = content(path, &file.size);
    good = host_load(i, &file);
    free(file.bytes);
    return good;
}

/* One block of one instance: the status; its two outputs from `out` on. */
static int play(int instance, const list *events, int64_t frames, float *out) {
    float *click = out, *tactor = out + LARGEST + GUARD;
    int i, status;
    for (i = 0; i < 2 * (LARGEST + GUARD); i++) out[i] = NAN;
    status = host_process(instance, events, frames, click, tactor);
    if (allocations) fail("allocated in process");
    for (i = 0; i < LARGEST + GUARD; i++) {
        if (i >= frames && !(isnan(click[i]) && isnan(tactor[i]))) fail("written beyond the block");
        if (i < frames && !((click[i] == 0 || isnormal(click[i])) && (tactor[i] == 0 || isnormal(tactor[i]))))
            fail("not a normal number");
    }
    return status;
}

static int play_all(char **given) {
    static float out[2][2 * (LARGEST + GUARD)];
    double rate = atof(given[3]);
    int64_t fixed = atol(given[4]), frames = atol(given[5]), warm = atol(given[10]), done, n = 0, i;
    size_t bytes;
    row *rows = content(given[6], &bytes);
    int64_t total = (int64_t)(bytes / sizeof *rows), next, pass;
    FILE *file = fopen(given[7], "wb");
    uint32_t random = 1;
    int status = 0;
    for (i = 0; i < 2; i++) {
        list before = {rows, 0, 0}, after;
        if (*given[8] == '/' && !load((int)i, given[8])) fail("state refused");
        while (before.count < total && rows[before.count].frame == -1) before.count++;
        host_flush((int)i, &before);
        if (!host_activate((int)i, rate)) fail("not activated");
        after = (list){rows + before.count, 0, 0};
        while (before.count + after.count < total && after.rows[after.count].frame < 0) after.count++;
        host_flush((int)i, &after);
        if (*given[8] == '+' && !load((int)i, given[8] + 1)) fail("state refused");
    }
    for (pass = warm ? 0 : 1; pass < 2; pass++) {
        int64_t end = pass ? frames : warm;
        transport.is_known = false, transport.rate = rate;
        for (next = 0; next < total && rows[next].frame < 0;) next++;
        for (done = 0; done < end; done += n) {
            list events = {rows + next, 0, done};
            random = random * 1664525u + 1013904223u;
            n = fixed ? fixed : 1 + (int64_t)(random >> 23);
            if (n > end - done) n = end - done;
            while (next < total && rows[next].frame < done + n) next++, events.count++;
            transport_hear(&events, done);
            for (i = 0; i < 2; i++) status = play((int)i, &events, n, out[i]);
            transport_hear(&events, done + n);
            for (i = 0; pass && i < n; i++) {
                float pair[2] = {out[0][i], out[0][LARGEST + GUARD + i]};
                float twin[2] = {out[1][i], out[1][LARGEST + GUARD + i]};
                if (memcmp(pair, twin, sizeof pair)) fail("two instances differ");
                fwrite(pair, sizeof pair, 1, file);
            }
        }
        for (i = 0; !pass && i < 2; i++) host_reset((int)i);
    }
    fclose(file);
    if (strcmp(given[9], "-")) {
        memory_file to = {NULL, 0, 0};
        if (!host_save(0, &to) || !(file = fopen(given[9], "wb"))) fail("not saved");
        fwrite(to.bytes, 1, to.size, file), fclose(file), free(to.bytes);
    }
    printf("%d %u %u %d %d %ld\n", status, host_latency(), host_tail(), tail_changes, rescans, told);
    free(rows);
    return 0;
}

/* Whether what a library allocates is seen. */
static void check_watch(void) {
#ifdef __GLIBC__
    char *volatile copy;
    processing = 1, copy = strdup("seen"), free(copy), processing = 0;
    if (allocations != 2) fail("malloc isn't watched");
    allocations = 0;
#endif
}

int main(int count, char **given) {
    void *library = count > 2 ? library_open(given[1]) : NULL;
    int i;
    if (!library) fail("no library");
    check_watch();
    host_open(library, given[1]);
    if (!strcmp(given[2], "list")) host_list();
    else if (!strcmp(given[2], "probe")) host_probe();
    else if (!strcmp(given[2], "load")) {
        for (i = 3; i < count; i++) printf("%d", load(0, given[i]));
        printf("\n%s", logged);
    } else if (!strcmp(given[2], "texts") && count > 4) {
        if (*given[3] == '/' && !load(0, given[3])) fail("state refused");
        for (i = 5; i < count; i++) {
            double value;
            char text[256];
            if (host_text((unsigned)strtoul(given[4], NULL, 10), given[i], &value, text)) printf("%.17g\t%s\n", value, text);
            else printf("refused\n");
        }
    } else if (count > 10) play_all(given);
    else fail("usage");
    host_close();
    return 0;
}
