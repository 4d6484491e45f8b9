/* A CLAP host for the tests. Every block is checked: each sample written, none beyond, all normal
   numbers, nothing allocated, and a second instance beside it that does the same.

   clap_host PLUGIN list
   clap_host PLUGIN play RATE BLOCK FRAMES EVENTS OUT STATE_IN STATE_OUT WARM
   clap_host PLUGIN load STATE...           says 1 for each that is taken, 0 for each refused

   BLOCK 0: of any size from 1 to 512. EVENTS: rows of kind (0 value, 1 key down, 2 key up, 3 MIDI),
   number, frame, value; those at -1 are flushed before it is active, those at -2 to -9 in a flush
   after it is. STATE_*: a path or -; STATE_IN is loaded before it is active, with a + before it
   after. WARM: frames of the same events that are played before a
   reset. OUT: the two outputs' samples in turn. */
#include "clap.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void __libc_free(void *);
static int processing;
static long allocations;
void *malloc(size_t n) { allocations += processing; return __libc_malloc(n); }
void *calloc(size_t n, size_t m) { allocations += processing; return __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { allocations += processing; return __libc_realloc(p, n); }
void free(void *p) { allocations += processing; __libc_free(p); }

enum { LARGEST = 4096, GUARD = 16 };
typedef struct { int64_t kind, number, frame; double value; } row;
typedef struct { const row *rows; int64_t count, first; } list;

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

static int tail_changes, rescans;
static void host_tail_changed(const clap_host_t *host) { (void)host, tail_changes++; }
static void host_rescan(const clap_host_t *host, clap_param_rescan_flags flags) { (void)host, (void)flags, rescans++; }
static const void *host_extension(const clap_host_t *host, const char *id) {
    static const clap_host_tail_t tail = {host_tail_changed};
    static const clap_host_params_t params = {host_rescan, NULL, NULL};
    (void)host;
    if (!strcmp(id, CLAP_EXT_TAIL)) return &tail;
    return strcmp(id, CLAP_EXT_PARAMS) ? NULL : &params;
}
static void host_request(const clap_host_t *host) { (void)host; }
static const clap_host_t host = {CLAP_VERSION_INIT, NULL, "test", "", "", "", host_extension,
                                 host_request, host_request, host_request};

static uint32_t events_size(const clap_input_events_t *in) { return (uint32_t)((list *)in->ctx)->count; }
static const clap_event_header_t *events_get(const clap_input_events_t *in, uint32_t index) {
    static union { clap_event_param_value_t value; clap_event_note_t note; clap_event_midi_t midi; } event;
    list *events = (list *)in->ctx;
    const row *r = events->rows + index;
    memset(&event, 0, sizeof event);
    event.value.header.size = sizeof event;
    event.value.header.time = r->frame < events->first ? 0 : (uint32_t)(r->frame - events->first);
    if (r->kind == 0) {
        event.value.header.type = CLAP_EVENT_PARAM_VALUE;
        event.value.param_id = (clap_id)r->number, event.value.value = r->value;
    } else if (r->kind < 3) {
        event.note.header.type = r->kind == 1 ? CLAP_EVENT_NOTE_ON : CLAP_EVENT_NOTE_OFF;
        event.note.key = (int16_t)r->number, event.note.velocity = r->value;
    } else {
        event.midi.header.type = CLAP_EVENT_MIDI;
        event.midi.data[0] = (uint8_t)(r->number >> 16), event.midi.data[1] = (uint8_t)(r->number >> 8);
        event.midi.data[2] = (uint8_t)r->number;
    }
    return &event.value.header;
}
static long told;
static bool events_push(const clap_output_events_t *out, const clap_event_header_t *event) {
    (void)out, (void)event, told++;
    return true;
}
static const clap_output_events_t nowhere = {NULL, events_push};

typedef struct { char *bytes; size_t size, at; } memory_file;
static int64_t stream_write(const clap_ostream_t *stream, const void *data, uint64_t size) {
    memory_file *to = (memory_file *)stream->ctx;
    uint64_t n = size < 7 ? size : 7;
    to->bytes = realloc(to->bytes, to->size + n);
    memcpy(to->bytes + to->size, data, n), to->size += n;
    return (int64_t)n;
}
static int64_t stream_read(const clap_istream_t *stream, void *data, uint64_t size) {
    memory_file *from = (memory_file *)stream->ctx;
    uint64_t n = size < 5 ? size : 5;
    if (n > from->size - from->at) n = from->size - from->at;
    memcpy(data, from->bytes + from->at, n), from->at += n;
    return (int64_t)n;
}
static bool load(const clap_plugin_t *plugin, const char *path) {
    memory_file file = {NULL, 0, 0};
    clap_istream_t stream = {&file, stream_read};
    const clap_plugin_state_t *state = plugin->get_extension(plugin, CLAP_EXT_STATE);
    bool taken;
    file.bytes = content(path, &file.size);
    taken = state->load(plugin, &stream);
    free(file.bytes);
    return taken;
}

/* One block of one instance: the status; its two outputs from `out` on. */
static int play(const clap_plugin_t *plugin, list *events, int64_t frames, float *out) {
    float *click = out, *tactor = out + LARGEST + GUARD;
    clap_audio_buffer_t ports[2] = {{&click, NULL, 1, 0, 0}, {&tactor, NULL, 1, 0, 0}};
    clap_input_events_t in = {events, events_size, events_get};
    clap_process_t block = {-1, (uint32_t)frames, NULL, NULL, ports, 0, 2, &in, &nowhere};
    int i, status;
    for (i = 0; i < 2 * (LARGEST + GUARD); i++) out[i] = NAN;
    processing = 1;
    status = plugin->process(plugin, &block);
    processing = 0;
    if (allocations) fail("allocated in process");
    for (i = 0; i < LARGEST + GUARD; i++) {
        if (i >= frames && !(isnan(click[i]) && isnan(tactor[i]))) fail("written beyond the block");
        if (i < frames && !((click[i] == 0 || isnormal(click[i])) && (tactor[i] == 0 || isnormal(tactor[i]))))
            fail("not a normal number");
    }
    return status;
}

int main(int count, char **given) {
    static float out[2][2 * (LARGEST + GUARD)];
    void *library = count > 2 ? dlopen(given[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    const clap_plugin_entry_t *entry = library ? dlsym(library, "clap_entry") : NULL;
    const clap_plugin_factory_t *factory;
    const clap_plugin_descriptor_t *descriptor;
    const clap_plugin_t *plugins[2];
    const clap_plugin_params_t *params;
    uint32_t i;
    if (!entry || !entry->init(given[1])) fail("no plugin");
    factory = entry->get_factory(CLAP_PLUGIN_FACTORY_ID);
    if (!factory || factory->get_plugin_count(factory) != 1) fail("no factory");
    descriptor = factory->get_plugin_descriptor(factory, 0);
    for (i = 0; i < 2; i++) {
        plugins[i] = factory->create_plugin(factory, &host, descriptor->id);
        if (!plugins[i] || !plugins[i]->init(plugins[i])) fail("no instance");
    }
    params = plugins[0]->get_extension(plugins[0], CLAP_EXT_PARAMS);
    if (!strcmp(given[2], "list")) {
        const clap_plugin_audio_ports_t *audio = plugins[0]->get_extension(plugins[0], CLAP_EXT_AUDIO_PORTS);
        clap_audio_port_info_t port;
        clap_param_info_t info;
        printf("%s\t%s\n", descriptor->id, descriptor->name);
        for (i = 0; audio->get(plugins[0], i, false, &port); i++)
            printf("output\t%s\t%u\n", port.name, port.channel_count);
        for (i = 0; params->get_info(plugins[0], i, &info); i++) {
            char text[256] = "", again[256] = "";
            double value = NAN;
            if (!params->value_to_text(plugins[0], info.id, info.default_value, text, sizeof text)) fail("no text");
            if (!params->text_to_value(plugins[0], info.id, text, &value)) fail(text);
            if (!params->value_to_text(plugins[0], info.id, value, again, sizeof again)) fail("no text");
            if (strcmp(text, again)) fail(again);
            printf("%u\t%s\t%s\t%.17g\t%.17g\t%.17g\t%u\t%s\n", info.id, info.name, info.module,
                   info.min_value, info.max_value, info.default_value, info.flags, text);
        }
    } else if (!strcmp(given[2], "load")) {
        for (i = 3; i < (uint32_t)count; i++) printf("%d", load(plugins[0], given[i]));
        printf("\n");
    } else if (count > 10) {
        double rate = atof(given[3]);
        int64_t fixed = atol(given[4]), frames = atol(given[5]), warm = atol(given[10]), done, n = 0;
        size_t bytes;
        row *rows = content(given[6], &bytes);
        int64_t total = (int64_t)(bytes / sizeof *rows), next, pass;
        FILE *file = fopen(given[7], "wb");
        uint32_t random = 1;
        int status = 0;
        for (i = 0; i < 2; i++) {
            list before = {rows, 0, 0}, after;
            clap_input_events_t in = {&before, events_size, events_get};
            if (*given[8] == '/' && !load(plugins[i], given[8])) fail("state refused");
            while (before.count < total && rows[before.count].frame == -1) before.count++;
            params->flush(plugins[i], &in, &nowhere);
            if (!plugins[i]->activate(plugins[i], rate, 1, LARGEST)) fail("not activated");
            if (!plugins[i]->start_processing(plugins[i])) fail("not started");
            after = (list){rows + before.count, 0, 0};
            while (before.count + after.count < total && after.rows[after.count].frame < 0) after.count++;
            in.ctx = &after;
            params->flush(plugins[i], &in, &nowhere);
            if (*given[8] == '+' && !load(plugins[i], given[8] + 1)) fail("state refused");
        }
        for (pass = warm ? 0 : 1; pass < 2; pass++) {
            int64_t end = pass ? frames : warm;
            for (next = 0; next < total && rows[next].frame < 0;) next++;
            for (done = 0; done < end; done += n) {
                list events = {rows + next, 0, done};
                random = random * 1664525u + 1013904223u;
                n = fixed ? fixed : 1 + (int64_t)(random >> 23);
                if (n > end - done) n = end - done;
                while (next < total && rows[next].frame < done + n) next++, events.count++;
                for (i = 0; i < 2; i++) status = play(plugins[i], &events, n, out[i]);
                for (i = 0; pass && i < (uint32_t)n; i++) {
                    float pair[2] = {out[0][i], out[0][LARGEST + GUARD + i]};
                    float twin[2] = {out[1][i], out[1][LARGEST + GUARD + i]};
                    if (memcmp(pair, twin, sizeof pair)) fail("two instances differ");
                    fwrite(pair, sizeof pair, 1, file);
                }
            }
            if (!pass)
                for (i = 0; i < 2; i++) plugins[i]->reset(plugins[i]);
        }
        fclose(file);
        if (strcmp(given[9], "-")) {
            memory_file to = {NULL, 0, 0};
            clap_ostream_t stream = {&to, stream_write};
            const clap_plugin_state_t *state = plugins[0]->get_extension(plugins[0], CLAP_EXT_STATE);
            if (!state->save(plugins[0], &stream) || !(file = fopen(given[9], "wb"))) fail("not saved");
            fwrite(to.bytes, 1, to.size, file), fclose(file), free(to.bytes);
        }
        printf("%d %u %u %d %d %ld\n", status,
               ((const clap_plugin_latency_t *)plugins[0]->get_extension(plugins[0], CLAP_EXT_LATENCY))->get(plugins[0]),
               ((const clap_plugin_tail_t *)plugins[0]->get_extension(plugins[0], CLAP_EXT_TAIL))->get(plugins[0]),
               tail_changes, rescans, told);
        for (i = 0; i < 2; i++) plugins[i]->stop_processing(plugins[i]), plugins[i]->deactivate(plugins[i]);
        free(rows);
    } else fail("usage");
    for (i = 0; i < 2; i++) plugins[i]->destroy(plugins[i]);
    entry->deinit();
    dlclose(library);
    return 0;
}
