/* A bundle as a CLAP plugin: an instrument with two mono outputs, the clicks and the tactor's. */
#include "clap.h"
#include "state.h"

typedef struct {
    clap_plugin_t plugin;
    const clap_host_t *host;
    const clap_host_tail_t *host_tail;
    int64_t told_tail;
    voice voice;
} instance;

static instance *of(const clap_plugin_t *plugin) { return (instance *)plugin->plugin_data; }

/* ---- values: what the host calls parameters */

static int which_is(clap_id number) { return value_of(number, UINT32_MAX); }

/* A host has 0 to 1 on a logarithmic range, else the value itself. */
static double to_host(const voice *v, int which, double plain) {
    return value_is_log(which) ? value_normal(v, which, plain) : plain;
}
static double from_host(const voice *v, int which, double said, const double *known) {
    return value_is_log(which) ? value_plain(v, which, said, known) : said;
}
static double from_host_now(voice *v, int which, double said) {
    double known[VOICE_VALUES];
    int i;
    for (i = 0; i < VOICE_VALUES; i++) known[i] = atomic_load(&v->values[i]);
    return from_host(v, which, said, known);
}

static uint32_t CLAP_ABI params_count(const clap_plugin_t *plugin) {
    (void)plugin;
    return VOICE_VALUES;
}
static bool CLAP_ABI params_info(const clap_plugin_t *plugin, uint32_t index, clap_param_info_t *info) {
    const voice *v = &of(plugin)->voice;
    int which = (int)index;
    if (index >= VOICE_VALUES) return false;
    memset(info, 0, sizeof *info);
    info->id = value_number(which);
    info->flags = CLAP_PARAM_IS_AUTOMATABLE | (voice_is_choice(which) ? CLAP_PARAM_IS_STEPPED : 0);
    if (value_is_hidden(v, which)) info->flags = CLAP_PARAM_IS_STEPPED | CLAP_PARAM_IS_HIDDEN;
    snprintf(info->name, sizeof info->name, "%s", value_name(which));
    if (which >= VOICE_OWN)
        snprintf(info->module, sizeof info->module, "%s", bundle_labels[which - VOICE_OWN].section);
    info->min_value = to_host(v, which, voice_lowest(which));
    info->max_value = to_host(v, which, voice_highest(v, which));
    info->default_value = to_host(v, which, voice_default(v, which));
    return true;
}
static bool CLAP_ABI params_value(const clap_plugin_t *plugin, clap_id id, double *value) {
    int which = which_is(id);
    if (which < 0) return false;
    *value = to_host(&of(plugin)->voice, which, atomic_load(&of(plugin)->voice.values[which]));
    return true;
}
static bool CLAP_ABI params_to_text(
    const clap_plugin_t *plugin, clap_id id, double value, char *text, uint32_t size) {
    voice *v = &of(plugin)->voice;
    int which = which_is(id);
    size_t length;
    if (which < 0 || !size || (value_is_log(which) && !(value >= 0.0 && value <= 1.0))) return false;
    if (!value_to_text(v, which, from_host_now(v, which, value), text, size)) return false;
    length = strlen(text);
    if (*value_unit(which)) snprintf(text + length, size - length, " %s", value_unit(which));
    return true;
}
static bool CLAP_ABI params_from_text(
    const clap_plugin_t *plugin, clap_id id, const char *text, double *value) {
    int which = which_is(id);
    if (which < 0 || !value_from_text(&of(plugin)->voice, which, text, value)) return false;
    *value = to_host(&of(plugin)->voice, which, *value);
    return true;
}

/* ---- events */

static void tell(const clap_output_events_t *out, const voice *v, int which, uint32_t time) {
    clap_event_param_value_t event;
    memset(&event, 0, sizeof event);
    event.header.size = sizeof event, event.header.time = time;
    event.header.space_id = CLAP_CORE_EVENT_SPACE_ID, event.header.type = CLAP_EVENT_PARAM_VALUE;
    event.param_id = value_number(which), event.value = to_host(v, which, v->applied[which]);
    event.note_id = event.port_index = event.channel = event.key = -1;
    if (out) out->try_push(out, &event.header);
}

static void hear_transport(voice *v, const clap_event_transport_t *now, int32_t at) {
    const uint32_t needed = CLAP_TRANSPORT_IS_PLAYING | CLAP_TRANSPORT_HAS_SECONDS_TIMELINE;
    if (at > v->done) voice_run(v, at);
    voice_transport(v, (double)now->song_pos_seconds / 2147483648.0, (now->flags & needed) == needed, at);
}

/* An event at frame `at` of the block; a flush has no frames: at once. */
static void hear(voice *v, const clap_event_header_t *event, int32_t at, const clap_output_events_t *out) {
    uint32_t time = at < 0 ? 0 : (uint32_t)at;
    int which;
    if (event->space_id != CLAP_CORE_EVENT_SPACE_ID) return;
    if (event->type == CLAP_EVENT_PARAM_VALUE) {
        const clap_event_param_value_t *set = (const clap_event_param_value_t *)event;
        double before = v->applied[VOICE_PRESET];
        if ((which = which_is(set->param_id)) < 0) return;
        voice_set(v, which, from_host(v, which, set->value, v->applied), at);
        if (v->applied[VOICE_PRESET] != before)
            for (which = VOICE_OWN; which < VOICE_VALUES; which++) tell(out, v, which, time);
    } else if (event->type == CLAP_EVENT_NOTE_ON) {
        const clap_event_note_t *note = (const clap_event_note_t *)event;
        if (note->key >= 0 && note->key < 128) voice_press(v, note->key, at);
    } else if (event->type == CLAP_EVENT_NOTE_OFF || event->type == CLAP_EVENT_NOTE_CHOKE) {
        voice_release(v, ((const clap_event_note_t *)event)->key, at);
    } else if (event->type == CLAP_EVENT_TRANSPORT) {
        hear_transport(v, (const clap_event_transport_t *)event, at);
    } else if (event->type == CLAP_EVENT_MIDI) {
        if (voice_midi(v, ((const clap_event_midi_t *)event)->data, at)) tell(out, v, VOICE_THETA2, time);
    }
}

/* A tail that depends on changed values isn't known: then it is without end, and sleep tells. */
static uint32_t CLAP_ABI tail_get(const clap_plugin_t *plugin) {
    voice *v = &of(plugin)->voice;
    int64_t tail = voice_active(v) ? voice_tail(v) : 0;
    return tail < 0 || tail > INT32_MAX ? INT32_MAX : (uint32_t)tail;
}

static void CLAP_ABI params_flush(
    const clap_plugin_t *plugin, const clap_input_events_t *in, const clap_output_events_t *out) {
    voice *v = &of(plugin)->voice;
    uint32_t i;
    if (voice_active(v)) voice_begin(v, NULL, NULL);
    for (i = 0; i < in->size(in); i++) hear(v, in->get(in, i), VOICE_AT_ONCE, out);
}

static clap_process_status CLAP_ABI process(const clap_plugin_t *plugin, const clap_process_t *block) {
    instance *self = of(plugin);
    voice *v = &self->voice;
    float *outputs[2] = {NULL, NULL};
    int32_t at = 0, frames = (int32_t)block->frames_count;
    uint32_t i, count = block->in_events ? block->in_events->size(block->in_events) : 0;
    if (!voice_active(v)) return CLAP_PROCESS_ERROR;
    for (i = 0; i < 2 && i < block->audio_outputs_count; i++) {
        clap_audio_buffer_t *buffer = &block->audio_outputs[i];
        buffer->constant_mask = 0;
        if (buffer->data32 && buffer->channel_count > 0) outputs[i] = buffer->data32[0];
    }
    voice_begin(v, outputs[0], outputs[1]);
    v->is_playing = 0; /* without a transport, or where it doesn't say */
    if (block->transport) hear_transport(v, block->transport, 0);
    for (i = 0; i < count; i++) {
        const clap_event_header_t *event = block->in_events->get(block->in_events, i);
        /* in their order, whatever a host's stamps are */
        if (event->time > (uint32_t)at) at = event->time < block->frames_count ? (int32_t)event->time : frames;
        hear(v, event, at, block->out_events);
    }
    voice_run(v, frames);
    if (self->host_tail && tail_get(plugin) != self->told_tail) {
        self->told_tail = tail_get(plugin);
        self->host_tail->changed(self->host);
    }
    return voice_asleep(v) ? CLAP_PROCESS_SLEEP : CLAP_PROCESS_CONTINUE;
}

/* ---- state */

static void report(const instance *self, clap_log_severity severity, const char *text) {
    const clap_host_log_t *log = (const clap_host_log_t *)self->host->get_extension(self->host, CLAP_EXT_LOG);
    if (log) log->log(self->host, severity, text);
}
static void report_missing(instance *self) {
    voice *v = &self->voice;
    char text[1024];
    int which;
    for (which = VOICE_TIMELINE; which <= VOICE_PRESET; which++) {
        int choice = v->in_place[which - VOICE_TIMELINE];
        const char *missing = value_missing(v, which, choice);
        char kept[VOICE_NAME];
        if (!missing) continue;
        value_copy(kept, sizeof kept - 1, missing); /* a longer one may end within a character */
        if (*missing)
            snprintf(text, sizeof text, "%s '%s' of the project is not in this plugin: '%s' plays in its "
                     "place, with the project's values; build the plugin with it", value_name(which), kept,
                     value_choice(v, which, choice));
        else
            snprintf(text, sizeof text, "The project was saved by an earlier build and names no %s: '%s' plays, "
                     "with the project's values; choose another %s if it is a wrong one", value_id(which),
                     value_choice(v, which, choice), value_id(which));
        report(self, CLAP_LOG_WARNING, text);
    }
}

static bool CLAP_ABI state_save(const clap_plugin_t *plugin, const clap_ostream_t *stream) {
    char bytes[STATE_BYTES];
    size_t done = 0;
    state_write(&of(plugin)->voice, bytes);
    while (done < sizeof bytes) {
        int64_t n = stream->write(stream, bytes + done, sizeof bytes - done);
        if (n <= 0) return false;
        done += (size_t)n;
    }
    return true;
}

static bool CLAP_ABI state_load(const clap_plugin_t *plugin, const clap_istream_t *stream) {
    instance *self = of(plugin);
    const clap_host_params_t *params;
    char bytes[STATE_MOST + 1];
    state_values read;
    size_t done = 0;
    for (;;) {
        int64_t n = stream->read(stream, bytes + done, sizeof bytes - done);
        if (n < 0 || (size_t)n > sizeof bytes - done) return false;
        if (n == 0) break;
        done += (size_t)n;
        if (done == sizeof bytes) return false;
    }
    if (!state_read(&self->voice, bytes, done, &read)) return false;
    state_take(&self->voice, &read);
    report_missing(self);
    params = (const clap_host_params_t *)self->host->get_extension(self->host, CLAP_EXT_PARAMS);
    if (params) params->rescan(self->host, CLAP_PARAM_RESCAN_VALUES | CLAP_PARAM_RESCAN_TEXT);
    return true;
}

/* ---- ports */

static uint32_t CLAP_ABI audio_count(const clap_plugin_t *plugin, bool is_input) {
    (void)plugin;
    return is_input ? 0 : 2;
}
static bool CLAP_ABI audio_get(
    const clap_plugin_t *plugin, uint32_t index, bool is_input, clap_audio_port_info_t *info) {
    (void)plugin;
    if (is_input || index > 1) return false;
    memset(info, 0, sizeof *info);
    info->id = index, info->channel_count = 1, info->port_type = CLAP_PORT_MONO;
    info->flags = index == 0 ? CLAP_AUDIO_PORT_IS_MAIN : 0;
    info->in_place_pair = CLAP_INVALID_ID;
    snprintf(info->name, sizeof info->name, index == 0 ? "Click" : "Tactor");
    return true;
}
static uint32_t CLAP_ABI notes_count(const clap_plugin_t *plugin, bool is_input) {
    (void)plugin;
    return is_input ? 1 : 0;
}
static bool CLAP_ABI notes_get(
    const clap_plugin_t *plugin, uint32_t index, bool is_input, clap_note_port_info_t *info) {
    (void)plugin;
    if (!is_input || index > 0) return false;
    memset(info, 0, sizeof *info);
    info->supported_dialects = CLAP_NOTE_DIALECT_CLAP | CLAP_NOTE_DIALECT_MIDI;
    info->preferred_dialect = CLAP_NOTE_DIALECT_MIDI; /* the modulation wheel comes with it */
    snprintf(info->name, sizeof info->name, "Taps");
    return true;
}
static uint32_t CLAP_ABI latency_get(const clap_plugin_t *plugin) {
    (void)plugin;
    return 0;
}

/* ---- the plugin */

static bool CLAP_ABI init(const clap_plugin_t *plugin) {
    instance *self = of(plugin);
    voice_init(&self->voice, 0, bundle_presets_count);
    self->host_tail = (const clap_host_tail_t *)self->host->get_extension(self->host, CLAP_EXT_TAIL);
    return true;
}
static void CLAP_ABI destroy(const clap_plugin_t *plugin) {
    voice_deactivate(&of(plugin)->voice);
    free(of(plugin));
}
static bool CLAP_ABI activate(const clap_plugin_t *plugin, double rate, uint32_t least, uint32_t most) {
    int32_t refused = voice_activate(&of(plugin)->voice, rate);
    (void)least, (void)most;
    if (refused) return report(of(plugin), CLAP_LOG_ERROR, overview_message(refused)), false;
    of(plugin)->told_tail = tail_get(plugin);
    return true;
}
static void CLAP_ABI deactivate(const clap_plugin_t *plugin) { voice_deactivate(&of(plugin)->voice); }
static bool CLAP_ABI start_processing(const clap_plugin_t *plugin) {
    return voice_active(&of(plugin)->voice);
}
static void CLAP_ABI stop_processing(const clap_plugin_t *plugin) { (void)plugin; }
static void CLAP_ABI reset(const clap_plugin_t *plugin) {
    if (voice_active(&of(plugin)->voice)) voice_restart(&of(plugin)->voice);
}
static void CLAP_ABI on_main_thread(const clap_plugin_t *plugin) { (void)plugin; }

static const void *CLAP_ABI get_extension(const clap_plugin_t *plugin, const char *id) {
    static const clap_plugin_params_t params = {params_count, params_info, params_value,
                                                params_to_text, params_from_text, params_flush};
    static const clap_plugin_state_t state = {state_save, state_load};
    static const clap_plugin_audio_ports_t audio = {audio_count, audio_get};
    static const clap_plugin_note_ports_t notes = {notes_count, notes_get};
    static const clap_plugin_latency_t latency = {latency_get};
    static const clap_plugin_tail_t tail = {tail_get};
    (void)plugin;
    if (!strcmp(id, CLAP_EXT_PARAMS)) return &params;
    if (!strcmp(id, CLAP_EXT_STATE)) return &state;
    if (!strcmp(id, CLAP_EXT_AUDIO_PORTS)) return &audio;
    if (!strcmp(id, CLAP_EXT_NOTE_PORTS)) return &notes;
    if (!strcmp(id, CLAP_EXT_LATENCY)) return &latency;
    return strcmp(id, CLAP_EXT_TAIL) ? NULL : &tail;
}

static const char *features[] = {"instrument", "synthesizer", NULL};
static const clap_plugin_descriptor_t descriptor = {
    CLAP_VERSION_INIT, bundle_id, bundle_name, "overView DSP", "", "", "",
    bundle_version, "A timeline under the hand: clicks to hear, a vibration to feel.", features,
};

static uint32_t CLAP_ABI factory_count(const clap_plugin_factory_t *factory) {
    (void)factory;
    return 1;
}
static const clap_plugin_descriptor_t *CLAP_ABI factory_descriptor(
    const clap_plugin_factory_t *factory, uint32_t index) {
    (void)factory;
    return index == 0 ? &descriptor : NULL;
}
static const clap_plugin_t *CLAP_ABI factory_create(
    const clap_plugin_factory_t *factory, const clap_host_t *host, const char *id) {
    instance *self;
    (void)factory;
    if (strcmp(id, bundle_id) || host->clap_version.major < 1) return NULL;
    if (!(self = (instance *)calloc(1, sizeof *self))) return NULL;
    self->host = host;
    self->plugin = (clap_plugin_t){&descriptor, self, init, destroy, activate, deactivate,
                                   start_processing, stop_processing, reset, process,
                                   get_extension, on_main_thread};
    return &self->plugin;
}

static bool CLAP_ABI entry_init(const char *path) {
    (void)path;
    return true;
}
static void CLAP_ABI entry_deinit(void) {}
static const void *CLAP_ABI entry_factory(const char *id) {
    static const clap_plugin_factory_t factory = {factory_count, factory_descriptor, factory_create};
    return strcmp(id, CLAP_PLUGIN_FACTORY_ID) ? NULL : &factory;
}

CLAP_EXPORT const clap_plugin_entry_t clap_entry = {
    CLAP_VERSION_INIT, entry_init, entry_deinit, entry_factory,
};
