/* CLAP in the tests' host. */
#include "plugin_host.h"

#include "clap.h"

static void host_tail_changed(const clap_host_t *host) { (void)host, tail_changes++; }
static void host_rescan(const clap_host_t *host, clap_param_rescan_flags flags) {
    (void)host, rescans++;
    /* the moments of another timeline are other texts */
    if (flags != (CLAP_PARAM_RESCAN_VALUES | CLAP_PARAM_RESCAN_TEXT)) fail("values or texts are not rescanned");
}
static void host_log(const clap_host_t *host, clap_log_severity severity, const char *text) {
    (void)host;
    if (severity >= CLAP_LOG_WARNING) snprintf(logged + strlen(logged), sizeof logged - strlen(logged), "%s\n", text);
}
static const void *host_extension(const clap_host_t *host, const char *id) {
    static const clap_host_tail_t tail = {host_tail_changed};
    static const clap_host_params_t params = {host_rescan, NULL, NULL};
    static const clap_host_log_t log = {host_log};
    (void)host;
    if (!strcmp(id, CLAP_EXT_LOG)) return &log;
    if (!strcmp(id, CLAP_EXT_TAIL)) return &tail;
    return strcmp(id, CLAP_EXT_PARAMS) ? NULL : &params;
}
static void host_request(const clap_host_t *host) { (void)host; }
static const clap_host_t host = {CLAP_VERSION_INIT, NULL, "test", "", "", "", host_extension,
                                 host_request, host_request, host_request};

static const clap_plugin_entry_t *entry;
static const clap_plugin_factory_t *factory;
static const clap_plugin_descriptor_t *descriptor;
static const clap_plugin_t *plugins[2];
static const clap_plugin_params_t *params;

static uint32_t events_size(const clap_input_events_t *in) { return (uint32_t)((const list *)in->ctx)->count; }
static const clap_event_header_t *events_get(const clap_input_events_t *in, uint32_t index) {
    static union {
        clap_event_param_value_t value;
        clap_event_note_t note;
        clap_event_midi_t midi;
        clap_event_transport_t transport;
    } event;
    const list *events = (const list *)in->ctx;
    const row *r = events->rows + index;
    memset(&event, 0, sizeof event);
    event.value.header.size = sizeof event;
    event.value.header.time = r->frame < events->first ? 0 : (uint32_t)(r->frame - events->first);
    if (r->kind == KIND_VALUE) {
        event.value.header.type = CLAP_EVENT_PARAM_VALUE;
        event.value.param_id = (clap_id)r->number, event.value.value = r->value;
    } else if (r->kind == KIND_TRANSPORT) {
        event.transport.header.type = CLAP_EVENT_TRANSPORT;
        event.transport.flags = CLAP_TRANSPORT_HAS_SECONDS_TIMELINE | (r->number ? CLAP_TRANSPORT_IS_PLAYING : 0);
        event.transport.song_pos_seconds = rounded(r->value * 2147483648.0);
    } else if (r->kind < KIND_MIDI) {
        event.note.header.type = r->kind == KIND_DOWN ? CLAP_EVENT_NOTE_ON : CLAP_EVENT_NOTE_OFF;
        event.note.key = (int16_t)r->number, event.note.velocity = r->value;
    } else {
        event.midi.header.type = CLAP_EVENT_MIDI;
        event.midi.data[0] = (uint8_t)(r->number >> 16), event.midi.data[1] = (uint8_t)(r->number >> 8);
        event.midi.data[2] = (uint8_t)r->number;
    }
    return &event.value.header;
}
static bool events_push(const clap_output_events_t *out, const clap_event_header_t *event) {
    (void)out, (void)event, told++;
    return true;
}
static const clap_output_events_t nowhere = {NULL, events_push};

static int64_t stream_write(const clap_ostream_t *stream, const void *data, uint64_t size) {
    return written((memory_file *)stream->ctx, data, size);
}
static int64_t stream_read(const clap_istream_t *stream, void *data, uint64_t size) {
    return taken((memory_file *)stream->ctx, data, size);
}
static const clap_plugin_state_t *state_of(int i) { return plugins[i]->get_extension(plugins[i], CLAP_EXT_STATE); }
static bool host_load(int i, memory_file *from) {
    clap_istream_t stream = {from, stream_read};
    return state_of(i)->load(plugins[i], &stream);
}
static bool host_save(int i, memory_file *to) {
    clap_ostream_t stream = {to, stream_write};
    return state_of(i)->save(plugins[i], &stream);
}

static void host_flush(int i, const list *events) {
    clap_input_events_t in = {(void *)(uintptr_t)events, events_size, events_get};
    processing = 1;
    params->flush(plugins[i], &in, &nowhere);
    processing = 0;
}
static bool host_activate(int i, double rate) {
    return plugins[i]->activate(plugins[i], rate, 1, LARGEST) && plugins[i]->start_processing(plugins[i]);
}
static int host_process(int i, const list *events, int64_t frames, float *click, float *tactor) {
    clap_audio_buffer_t ports[2] = {{&click, NULL, 1, 0, 0}, {&tactor, NULL, 1, 0, 0}};
    clap_input_events_t in = {(void *)(uintptr_t)events, events_size, events_get};
    clap_event_transport_t now = {.flags = CLAP_TRANSPORT_HAS_SECONDS_TIMELINE};
    clap_process_t block = {-1, (uint32_t)frames, NULL, NULL, ports, 0, 2, &in, &nowhere};
    int status;
    if (transport.is_known) block.transport = &now;
    if (transport.is_playing) now.flags |= CLAP_TRANSPORT_IS_PLAYING;
    now.song_pos_seconds = rounded(transport_seconds(events->first) * 2147483648.0);
    processing = 1;
    status = plugins[i]->process(plugins[i], &block);
    processing = 0;
    return status;
}
static void host_reset(int i) { processing = 1, plugins[i]->reset(plugins[i]), processing = 0; }
static unsigned host_latency(void) {
    return ((const clap_plugin_latency_t *)plugins[0]->get_extension(plugins[0], CLAP_EXT_LATENCY))->get(plugins[0]);
}
static unsigned host_tail(void) {
    return ((const clap_plugin_tail_t *)plugins[0]->get_extension(plugins[0], CLAP_EXT_TAIL))->get(plugins[0]);
}

static void host_open(void *library, const char *path) {
    int i;
    entry = (const clap_plugin_entry_t *)library_find(library, "clap_entry");
    if (!entry || !entry->init(path)) fail("no plugin");
    factory = entry->get_factory(CLAP_PLUGIN_FACTORY_ID);
    if (!factory || factory->get_plugin_count(factory) != 1) fail("no factory");
    descriptor = factory->get_plugin_descriptor(factory, 0);
    for (i = 0; i < 2; i++) {
        plugins[i] = factory->create_plugin(factory, &host, descriptor->id);
        if (!plugins[i] || !plugins[i]->init(plugins[i])) fail("no instance");
    }
    params = plugins[0]->get_extension(plugins[0], CLAP_EXT_PARAMS);
}
static void host_close(void) {
    int i;
    for (i = 0; i < 2; i++) {
        plugins[i]->stop_processing(plugins[i]), plugins[i]->deactivate(plugins[i]);
        plugins[i]->destroy(plugins[i]);
    }
    entry->deinit();
}

static bool host_text(unsigned number, const char *said, double *value, char text[256]) {
    if (!params->text_to_value(plugins[0], number, said, value)) return false;
    if (!params->value_to_text(plugins[0], number, *value, text, 256)) fail("no text");
    return true;
}
static void host_list(void) {
    const clap_plugin_audio_ports_t *audio = plugins[0]->get_extension(plugins[0], CLAP_EXT_AUDIO_PORTS);
    clap_audio_port_info_t port;
    clap_param_info_t info;
    uint32_t i;
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
}

#include "clap_probe.h"
