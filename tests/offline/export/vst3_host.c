/* VST3 in the tests' host: the first instance has its two outputs apart, the second has the first
   output as a stereo pair, and both must say the same. Values are normalised, 0 to 1. */
#include "plugin_host.h"

#include "vst3.h"

typedef struct { int32_t at; double value; } point;
typedef struct {
    const struct v3_param_value_queue *table;
    v3_param_id id;
    int32_t count;
    point *points;
} queue;
typedef struct {
    const struct v3_param_changes *table;
    int32_t count;
    queue *queues[128];
} changes;
typedef struct {
    const struct v3_event_list *table;
    uint32_t count;
    struct v3_event events[1024];
} notes;
typedef struct {
    const struct v3_bstream *table;
    memory_file *file;
} stream;

static struct v3_component const **components[2];
static struct v3_audio_processor const **processors[2];
static struct v3_edit_controller const **controllers[2];
static struct v3_plugin_factory_3 const **factory;
static struct v3_class_info_2 class_info;
static bool active[2];

static v3_result V3_API host_query(void *self, const v3_tuid iid, void **to) {
    (void)self, (void)iid, *to = NULL;
    return V3_NO_INTERFACE;
}
static uint32_t V3_API host_ref(void *self) { return (void)self, 1; }

static v3_param_id V3_API queue_id(void *self) { return ((queue *)self)->id; }
static int32_t V3_API queue_count(void *self) { return ((queue *)self)->count; }
static v3_result V3_API queue_get(void *self, int32_t index, int32_t *at, double *value) {
    const queue *q = (const queue *)self;
    if (index < 0 || index >= q->count) return V3_INVALID_ARG;
    *at = q->points[index].at, *value = q->points[index].value;
    return V3_OK;
}
static v3_result V3_API queue_add(void *self, int32_t at, double value, int32_t *index) {
    (void)self, (void)at;
    if (!(value >= 0.0 && value <= 1.0)) fail("told what isn't normalised");
    told++, *index = 0;
    return V3_OK;
}
static const struct v3_param_value_queue queue_table = {
    host_query, host_ref, host_ref, queue_id, queue_count, queue_get, queue_add};

static int32_t V3_API changes_count(void *self) { return ((changes *)self)->count; }
static struct v3_param_value_queue **V3_API changes_get(void *self, int32_t index) {
    return (struct v3_param_value_queue **)(void *)((changes *)self)->queues[index];
}
static struct v3_param_value_queue **V3_API changes_add(void *self, const v3_param_id *id, int32_t *index) {
    static queue sink = {&queue_table, 0, 0, NULL};
    (void)self, (void)id, *index = 0;
    return (struct v3_param_value_queue **)(void *)&sink;
}
static const struct v3_param_changes changes_table = {
    host_query, host_ref, host_ref, changes_count, changes_get, changes_add};

static uint32_t V3_API notes_count(void *self) { return ((notes *)self)->count; }
static v3_result V3_API notes_get(void *self, int32_t index, struct v3_event *event) {
    const notes *n = (const notes *)self;
    if (index < 0 || (uint32_t)index >= n->count) return V3_INVALID_ARG;
    *event = n->events[index];
    return V3_OK;
}
static v3_result V3_API notes_add(void *self, struct v3_event *event) {
    (void)self, (void)event;
    return V3_NOT_IMPLEMENTED;
}
static const struct v3_event_list notes_table = {
    host_query, host_ref, host_ref, notes_count, notes_get, notes_add};

static v3_result V3_API stream_read(void *self, void *to, int32_t size, int32_t *done) {
    *done = (int32_t)taken(((stream *)self)->file, to, (uint64_t)size);
    return V3_OK;
}
static v3_result V3_API stream_write(void *self, void *from, int32_t size, int32_t *done) {
    *done = (int32_t)written(((stream *)self)->file, from, (uint64_t)size);
    return V3_OK;
}
static const struct v3_bstream stream_table = {host_query, host_ref, host_ref, stream_read, stream_write, NULL, NULL};

/* Events as a VST3 host sorts them: points by parameter, notes, controllers as parameters. */
static changes sorted_changes = {&changes_table, 0, {NULL}};
static notes sorted_notes = {&notes_table, 0, {{0}}};
static void put_point(v3_param_id id, int32_t at, double value) {
    static queue queues[128];
    static point points[128][8192];
    int32_t i;
    for (i = 0; i < sorted_changes.count && sorted_changes.queues[i]->id != id;) i++;
    if (i == 128) fail("too many parameters");
    if (i == sorted_changes.count) {
        queues[i] = (queue){&queue_table, id, 0, points[i]};
        sorted_changes.queues[sorted_changes.count++] = &queues[i];
    }
    if (queues[i].count == 8192) fail("too many points");
    points[i][queues[i].count++] = (point){at, value};
}
static void put_note(bool down, int key, int32_t at, double velocity) {
    struct v3_event *event = &sorted_notes.events[sorted_notes.count++];
    if (sorted_notes.count == 1024) fail("too many notes");
    memset(event, 0, sizeof *event);
    event->sample_offset = at;
    event->type = down ? V3_EVENT_NOTE_ON : V3_EVENT_NOTE_OFF;
    if (down) event->note_on.pitch = (int16_t)key, event->note_on.velocity = (float)velocity;
    else event->note_off.pitch = (int16_t)key;
}
static void sort(const list *events) {
    struct v3_midi_mapping const **mapping;
    int64_t i;
    sorted_changes.count = 0, sorted_notes.count = 0;
    if ((*components[0])->query_interface(components[0], v3_midi_mapping_iid, (void **)&mapping)) fail("no MIDI");
    for (i = 0; i < events->count; i++) {
        const row *r = events->rows + i;
        int32_t at = r->frame < events->first ? 0 : (int32_t)(r->frame - events->first);
        int kind = (int)(r->number >> 16), number = (int)(r->number >> 8 & 127), value = (int)(r->number & 127);
        v3_param_id id;
        if (r->kind == KIND_VALUE) put_point((v3_param_id)r->number & INT32_MAX, at, r->value);
        else if (r->kind < KIND_MIDI) put_note(r->kind == KIND_DOWN, (int)r->number, at, r->value);
        else if ((kind & 0xF0) == 0x90 || (kind & 0xF0) == 0x80)
            put_note((kind & 0xF0) == 0x90 && value, number, at, value / 127.0);
        else if ((kind & 0xF0) == 0xB0
                 && (*mapping)->get_midi_controller_assignment(mapping, 0, 0, (int16_t)number, &id) == V3_OK)
            put_point(id, at, (float)value / 127.0f);
    }
    (*mapping)->unref(mapping);
}

static int process(int i, const list *events, int64_t frames, float *click, float *tactor) {
    float *first[2] = {click, i ? tactor : NULL}, *second[1] = {tactor}, *none[1] = {NULL};
    struct v3_audio_bus_buffers buses[2] = {{.num_channels = i ? 2 : 1, .channel_buffers_32 = first},
                                            {.num_channels = i ? 0 : 1, .channel_buffers_32 = i ? none : second}};
    struct v3_process_data data = {.symbolic_sample_size = V3_SAMPLE_32, .nframes = (int32_t)frames};
    struct v3_process_context now = {transport.is_playing ? V3_PLAYING : 0, transport.rate, 0};
    v3_result result;
    now.project_time_in_samples = rounded(transport_seconds(events->first) * transport.rate);
    if (transport.is_known) data.ctx = &now;
    sort(events);
    data.num_output_buses = frames ? 2 : 0, data.outputs = frames ? buses : NULL;
    data.input_params = (struct v3_param_changes **)(void *)&sorted_changes;
    data.output_params = (struct v3_param_changes **)(void *)&sorted_changes;
    data.input_events = (struct v3_event_list **)(void *)&sorted_notes;
    processing = 1;
    result = (*processors[i])->process(processors[i], &data);
    processing = 0;
    if (result != V3_OK) fail("not processed");
    return buses[0].channel_silence_bitset == (i ? 3 : 1) && (i || buses[1].channel_silence_bitset == 1) ? 4 : 1;
}
static int host_process(int i, const list *events, int64_t frames, float *click, float *tactor) {
    int status = process(i, events, frames, click, tactor);
    int64_t at;
    for (at = 0; at < frames && status == 4; at++)
        if (click[at] != 0.0f || tactor[at] != 0.0f) fail("sound is told as silence");
    return status;
}
static void host_flush(int i, const list *events) { process(i, events, 0, NULL, NULL); }
static bool host_activate(int i, double rate) {
    struct v3_process_setup setup = {0, V3_SAMPLE_32, LARGEST, rate};
    v3_speaker_arrangement outputs[2] = {i ? V3_SPEAKER_L | V3_SPEAKER_R : V3_SPEAKER_M, i ? 0 : V3_SPEAKER_M};
    if ((*processors[i])->set_bus_arrangements(processors[i], NULL, 0, outputs, 2) != V3_OK) fail("no such outputs");
    active[i] = true;
    return (*processors[i])->setup_processing(processors[i], &setup) == V3_OK
        && (*components[i])->set_active(components[i], 1) == V3_OK
        && (*processors[i])->set_processing(processors[i], 1) == V3_OK;
}
static void host_reset(int i) {
    (*processors[i])->set_processing(processors[i], 0), (*processors[i])->set_processing(processors[i], 1);
}
static unsigned host_latency(void) { return (*processors[0])->get_latency_samples(processors[0]); }
static unsigned host_tail(void) { return (*processors[0])->get_tail_samples(processors[0]); }

static bool host_load(int i, memory_file *from) {
    stream in = {&stream_table, from};
    bool good = (*components[i])->set_state(components[i], (struct v3_bstream **)(void *)&in) == V3_OK;
    from->at = 0;
    if (((*controllers[i])->set_component_state(controllers[i], (struct v3_bstream **)(void *)&in) == V3_OK) != good)
        fail("the controller takes it otherwise");
    return good;
}
static bool host_save(int i, memory_file *to) {
    stream out = {&stream_table, to};
    return (*components[i])->get_state(components[i], (struct v3_bstream **)(void *)&out) == V3_OK;
}

static void host_open(void *library, const char *path) {
#ifdef _WIN32
    bool (*enter)(void) = (bool (*)(void))library_find(library, "InitDll");
    if (!enter || !enter()) fail("no entry");
#else
    bool (*enter)(void *) = (bool (*)(void *))library_find(library, "ModuleEntry");
    if (!enter || !enter(library)) fail("no entry");
#endif
    const void *(V3_API *get)(void) = (const void *(V3_API *)(void))library_find(library, "GetPluginFactory");
    struct v3_class_info first;
    v3_tuid nobody = {0};
    void *none;
    int i;
    (void)path;
    if (!get || !(factory = (struct v3_plugin_factory_3 const **)get())) fail("no factory");
    if ((*factory)->num_classes(factory) != 1) fail("not one class");
    if ((*factory)->get_class_info(factory, 0, &first) || (*factory)->get_class_info_2(factory, 0, &class_info)) fail("no class");
    if (memcmp(&first, &class_info, sizeof first)) fail("two classes");
    if ((*factory)->create_instance(factory, nobody, v3_component_iid, &none) == V3_OK) fail("of any class");
    for (i = 0; i < 2; i++) {
        if ((*factory)->create_instance(factory, class_info.class_id, v3_component_iid, (void **)&components[i])
            || (*components[i])->initialize(components[i], NULL)
            || (*components[i])->query_interface(components[i], v3_audio_processor_iid, (void **)&processors[i])
            || (*components[i])->query_interface(components[i], v3_edit_controller_iid, (void **)&controllers[i]))
            fail("no instance");
    }
}
static void host_close(void) {
    int i;
    for (i = 0; i < 2; i++) {
        if (active[i]) (*processors[i])->set_processing(processors[i], 0), (*components[i])->set_active(components[i], 0);
        (*processors[i])->unref(processors[i]), (*controllers[i])->unref(controllers[i]);
        (*components[i])->terminate(components[i]);
        if ((*components[i])->unref(components[i]) != 0) fail("someone holds it");
    }
}

static const char *plain_text(const int16_t *text) {
    static char said[4][512];
    static int turn;
    char *to = said[turn = (turn + 1) % 4];
    int n = 0;
    for (; *text && n < 508; text++) {
        unsigned point = (uint16_t)*text;
        if (point > 0x7FF) to[n++] = (char)(0xE0 | point >> 12), to[n++] = (char)(0x80 | (point >> 6 & 63));
        else if (point > 0x7F) to[n++] = (char)(0xC0 | point >> 6);
        to[n++] = (char)(point > 0x7F ? 0x80 | (point & 63) : point);
    }
    to[n] = 0;
    return to;
}
static bool host_text(unsigned number, const char *said, double *value, char text[256]) {
    struct v3_edit_controller const **c = controllers[0];
    v3_str_128 wide;
    int n = 0;
    do wide[n] = said[n];
    while (said[n++]);
    if ((*c)->get_parameter_value_for_string(c, number, wide, value)) return false;
    if ((*c)->get_parameter_string_for_value(c, number, *value, wide)) fail("no text");
    snprintf(text, 256, "%s", plain_text(wide));
    return true;
}
static void host_list(void) {
    struct v3_edit_controller const **c = controllers[0];
    struct v3_bus_info bus;
    struct v3_param_info info;
    int32_t i;
    printf("%s\t%s\n", class_info.sub_categories, class_info.name);
    for (i = 0; i < (*components[0])->get_bus_count(components[0], V3_AUDIO, V3_OUTPUT); i++) {
        if ((*components[0])->get_bus_info(components[0], V3_AUDIO, V3_OUTPUT, i, &bus)) fail("no bus");
        printf("output\t%s\t%d\n", plain_text(bus.bus_name), bus.channel_count);
    }
    for (i = 0; i < (*c)->get_parameter_count(c); i++) {
        v3_str_128 text, again;
        double value = NAN, normal;
        if ((*c)->get_parameter_info(c, i, &info)) fail("no parameter");
        normal = info.default_normalised_value;
        if ((*c)->get_parameter_string_for_value(c, info.param_id, normal, text)) fail("no text");
        if (info.param_id > 1) { /* the others are MIDI's */
            if ((*c)->get_parameter_normalised(c, info.param_id) != normal) fail("not the default");
            if ((*c)->get_parameter_value_for_string(c, info.param_id, text, &value)) fail(plain_text(text));
            if ((*c)->get_parameter_string_for_value(c, info.param_id, value, again)) fail("no text");
            if (strcmp(plain_text(text), plain_text(again))) fail(plain_text(again));
        }
        printf("%u\t%s\t\t%.17g\t%.17g\t%.17g\t%d\t%s %s\n", info.param_id, plain_text(info.title),
               (*c)->normalised_parameter_to_plain(c, info.param_id, 0.0),
               (*c)->normalised_parameter_to_plain(c, info.param_id, 1.0),
               (*c)->normalised_parameter_to_plain(c, info.param_id, normal), info.flags, plain_text(text),
               plain_text(info.units));
    }
}

#include "vst3_probe.h"
