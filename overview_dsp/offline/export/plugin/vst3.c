/* A bundle as a VST3 plugin: an instrument with two outputs, the clicks and the tactor's. */
#include "vst3_events.h"

static const char maker[] = "overView DSP";
enum { BUSES = 2 };

/* ---- component */

static v3_result V3_API initialize(void *self, struct v3_funknown **context) {
    (void)self, (void)context;
    return V3_OK;
}
static v3_result V3_API terminate(void *self) {
    (void)self;
    return V3_OK;
}
static v3_result V3_API controller_class(void *self, v3_tuid id) {
    (void)self, (void)id;
    return V3_NOT_IMPLEMENTED; /* it is its own */
}
static v3_result V3_API set_io_mode(void *self, int32_t mode) {
    (void)self, (void)mode;
    return V3_NOT_IMPLEMENTED;
}
static int32_t V3_API bus_count(void *self, int32_t type, int32_t direction) {
    (void)self;
    if (type == V3_AUDIO) return direction == V3_OUTPUT ? BUSES : 0;
    return type == V3_EVENT && direction == V3_INPUT ? 1 : 0;
}
static v3_result V3_API bus_info(
    void *self, int32_t type, int32_t direction, int32_t index, struct v3_bus_info *info) {
    if (index < 0 || index >= bus_count(self, type, direction)) return V3_INVALID_ARG;
    memset(info, 0, sizeof *info);
    info->media_type = type, info->direction = direction;
    info->channel_count = type == V3_EVENT ? 16 : index ? 1 : OF(self, component)->channels;
    info->bus_type = index ? V3_AUX : V3_MAIN, info->flags = V3_DEFAULT_ACTIVE;
    wide(type == V3_EVENT ? "Taps" : index ? "Tactor" : "Click", info->bus_name, 128);
    return V3_OK;
}
static v3_result V3_API routing_info(
    void *self, struct v3_routing_info *input, struct v3_routing_info *output) {
    (void)self, (void)input, (void)output;
    return V3_NOT_IMPLEMENTED;
}
static v3_result V3_API activate_bus(
    void *self, int32_t type, int32_t direction, int32_t index, v3_bool state) {
    (void)state;
    return index >= 0 && index < bus_count(self, type, direction) ? V3_OK : V3_INVALID_ARG;
}
static v3_result V3_API set_active(void *self, v3_bool state) {
    instance *object = OF(self, component);
    if (!state) return voice_deactivate(&object->voice), V3_OK;
    if (object->rate <= 0.0) return V3_NOT_INITIALIZED;
    return voice_activate(&object->voice, object->rate) ? V3_FALSE : V3_OK;
}
static v3_result V3_API set_state(void *self, struct v3_bstream **stream) {
    instance *object = OF(self, component);
    state_values read;
    if (!stream_state(&object->voice, stream, &read)) return V3_FALSE;
    state_take(&object->voice, &read);
    show(object, read.values);
    return V3_OK;
}
static v3_result V3_API get_state(void *self, struct v3_bstream **stream) {
    char bytes[STATE_BYTES];
    int32_t done = 0, n;
    state_write(&OF(self, component)->voice, bytes);
    for (; done < STATE_BYTES; done += n) {
        n = 0;
        if ((*stream)->write(stream, bytes + done, STATE_BYTES - done, &n) != V3_OK || n <= 0) return V3_FALSE;
    }
    return V3_OK;
}

/* ---- audio processor */

static int channels_of(v3_speaker_arrangement arrangement) {
    int count = 0;
    for (; arrangement; arrangement &= arrangement - 1) count++;
    return count;
}
/* The first output takes the click, or, as a stereo pair, the click and the tactor. */
static v3_result V3_API set_arrangements(void *self, v3_speaker_arrangement *inputs, int32_t inputs_count,
                                         v3_speaker_arrangement *outputs, int32_t outputs_count) {
    int first;
    (void)inputs;
    if (inputs_count != 0 || outputs_count < 1 || outputs_count > BUSES) return V3_FALSE;
    first = channels_of(outputs[0]);
    if (first < 1 || first > 2 || (outputs_count > 1 && channels_of(outputs[1]) > 1)) return V3_FALSE;
    OF(self, processor)->channels = first;
    return V3_OK;
}
static v3_result V3_API get_arrangement(
    void *self, int32_t direction, int32_t index, v3_speaker_arrangement *arrangement) {
    if (direction != V3_OUTPUT || index < 0 || index >= BUSES) return V3_INVALID_ARG;
    *arrangement = index || OF(self, processor)->channels == 1 ? V3_SPEAKER_M : V3_SPEAKER_L | V3_SPEAKER_R;
    return V3_OK;
}
static v3_result V3_API can_process(void *self, int32_t size) {
    (void)self;
    return size == V3_SAMPLE_32 ? V3_OK : V3_FALSE;
}
static uint32_t V3_API latency(void *self) {
    (void)self;
    return 0;
}
static v3_result V3_API setup(void *self, struct v3_process_setup *setup) {
    if (setup->symbolic_sample_size != V3_SAMPLE_32) return V3_FALSE;
    OF(self, processor)->rate = setup->sample_rate;
    return V3_OK;
}
static v3_result V3_API set_processing(void *self, v3_bool state) {
    voice *v = &OF(self, processor)->voice;
    if (state && voice_active(v) && voice_restart(v)) return V3_FALSE;
    return V3_OK;
}
/* A tail that depends on changed values isn't known: then it is without end, and silence is told. */
static uint32_t V3_API tail(void *self) {
    voice *v = &OF(self, processor)->voice;
    int64_t frames = voice_active(v) ? voice_tail(v) : 0;
    return frames < 0 || frames >= V3_NO_TAIL_END ? V3_NO_TAIL_END : (uint32_t)frames;
}

static float *channel(const struct v3_process_data *data, int32_t bus, int32_t number) {
    if (bus >= data->num_output_buses || number >= data->outputs[bus].num_channels) return NULL;
    return data->outputs[bus].channel_buffers_32 ? data->outputs[bus].channel_buffers_32[number] : NULL;
}
static int is_silent(const float *samples, int32_t frames) {
    while (frames > 0 && samples[frames - 1] == 0.0f) frames--;
    return frames == 0;
}
static v3_result V3_API process(void *self, struct v3_process_data *data) {
    instance *object = OF(self, processor);
    voice *v = &object->voice;
    float *click = channel(data, 0, 0), *beside = channel(data, 0, 1), *apart = channel(data, 1, 0);
    size_t bytes = data->nframes > 0 ? (size_t)data->nframes * sizeof(float) : 0;
    int32_t bus, number;
    if (data->symbolic_sample_size != V3_SAMPLE_32) return V3_INVALID_ARG;
    if (!voice_active(v) && bytes) return V3_NOT_INITIALIZED;
    if (voice_active(v)) voice_begin(v, click, beside ? beside : apart);
    if (voice_active(v)) {
        const struct v3_process_context *now = data->ctx;
        int is_playing = now && (now->state & V3_PLAYING);
        voice_transport(v, is_playing ? (double)now->project_time_in_samples / v->rate : 0.0, is_playing, 0);
    }
    hear(object, data); /* without frames, values only */
    if (!bytes) return V3_OK;
    voice_run(v, data->nframes);
    if (beside && apart) memcpy(apart, beside, bytes);
    for (bus = 0; bus < data->num_output_buses; bus++) {
        data->outputs[bus].channel_silence_bitset = 0;
        for (number = 0; number < data->outputs[bus].num_channels; number++) {
            float *samples = channel(data, bus, number);
            if (!samples) continue;
            if (samples != click && samples != beside && samples != apart) memset(samples, 0, bytes);
            if (number < 64 && is_silent(samples, data->nframes))
                data->outputs[bus].channel_silence_bitset |= (uint64_t)1 << number;
        }
    }
    return V3_OK;
}

static uint32_t V3_API context_needed(void *self) {
    (void)self;
    return V3_NEEDS_TRANSPORT_STATE;
}

/* ---- the object */

static v3_result query(instance *object, const v3_tuid iid, void **face) {
    *face = NULL;
    if (v3_tuid_match(iid, v3_funknown_iid) || v3_tuid_match(iid, v3_plugin_base_iid)
        || v3_tuid_match(iid, v3_component_iid)) *face = &object->component;
    else if (v3_tuid_match(iid, v3_audio_processor_iid)) *face = &object->processor;
    else if (v3_tuid_match(iid, v3_edit_controller_iid)) *face = &object->controller;
    else if (v3_tuid_match(iid, v3_midi_mapping_iid)) *face = &object->mapping;
    else if (v3_tuid_match(iid, v3_process_context_requirements_iid)) *face = &object->requirements;
    if (!*face) return V3_NO_INTERFACE;
    atomic_fetch_add(&object->references, 1);
    return V3_OK;
}
static uint32_t release(instance *object) {
    uint32_t left = atomic_fetch_sub(&object->references, 1) - 1;
    if (left == 0) voice_deactivate(&object->voice), free(object);
    return left;
}
#define FACE(face) \
    static v3_result V3_API face##_query(void *self, const v3_tuid iid, void **to) { \
        return query(OF(self, face), iid, to); \
    } \
    static uint32_t V3_API face##_ref(void *self) { \
        return atomic_fetch_add(&OF(self, face)->references, 1) + 1; \
    } \
    static uint32_t V3_API face##_unref(void *self) { return release(OF(self, face)); }
FACE(component)
FACE(processor)
FACE(controller)
FACE(mapping)
FACE(requirements)

static const struct v3_component component = {
    component_query, component_ref, component_unref, initialize, terminate, controller_class,
    set_io_mode, bus_count, bus_info, routing_info, activate_bus, set_active, set_state, get_state,
};
static const struct v3_audio_processor processor = {
    processor_query, processor_ref, processor_unref, set_arrangements, get_arrangement, can_process,
    latency, setup, set_processing, process, tail,
};
static const struct v3_edit_controller controller = {
    controller_query, controller_ref, controller_unref, initialize, terminate, component_state,
    controller_state, controller_state, parameter_count, parameter_info, parameter_text,
    parameter_from_text, parameter_plain, parameter_normal, parameter_get, parameter_set,
    set_handler, create_view,
};
static const struct v3_midi_mapping mapping = {
    mapping_query, mapping_ref, mapping_unref, controller_assignment,
};
static const struct v3_process_context_requirements requirements = {
    requirements_query, requirements_ref, requirements_unref, context_needed,
};

/* ---- factory */

static void class_id(v3_tuid id) {
    const uint32_t *word = bundle_class;
    const v3_tuid made = V3_ID(word[0], word[1], word[2], word[3]);
    memcpy(id, made, sizeof made);
}
static v3_result V3_API factory_query(void *self, const v3_tuid iid, void **to) {
    int known = v3_tuid_match(iid, v3_funknown_iid) || v3_tuid_match(iid, v3_plugin_factory_iid)
        || v3_tuid_match(iid, v3_plugin_factory_2_iid) || v3_tuid_match(iid, v3_plugin_factory_3_iid);
    *to = known ? self : NULL;
    return known ? V3_OK : V3_NO_INTERFACE;
}
static uint32_t V3_API factory_ref(void *self) {
    (void)self;
    return 1;
}
static v3_result V3_API factory_info(void *self, struct v3_factory_info *info) {
    (void)self;
    memset(info, 0, sizeof *info);
    memcpy(info->vendor, maker, sizeof maker);
    info->flags = 0x10; /* names are UTF-16 */
    return V3_OK;
}
static int32_t V3_API class_count(void *self) {
    (void)self;
    return 1;
}
static v3_result V3_API class_info_2(void *self, int32_t index, struct v3_class_info_2 *info) {
    (void)self;
    if (index != 0) return V3_INVALID_ARG;
    memset(info, 0, sizeof *info);
    class_id(info->class_id);
    info->cardinality = INT32_MAX;
    snprintf(info->category, sizeof info->category, "Audio Module Class");
    value_copy(info->name, sizeof info->name, bundle_name);
    snprintf(info->sub_categories, sizeof info->sub_categories, "Instrument|Synth");
    snprintf(info->vendor, sizeof info->vendor, "%s", maker);
    snprintf(info->version, sizeof info->version, "%s", bundle_version);
    snprintf(info->sdk_version, sizeof info->sdk_version, "VST 3.7.4");
    return V3_OK;
}
static v3_result V3_API class_info_1(void *self, int32_t index, struct v3_class_info *info) {
    struct v3_class_info_2 all;
    v3_result result = class_info_2(self, index, &all);
    if (result == V3_OK) memcpy(info, &all, sizeof *info); /* it begins with the same */
    return result;
}
static v3_result V3_API class_info_3(void *self, int32_t index, struct v3_class_info_3 *info) {
    struct v3_class_info_2 all;
    v3_result result = class_info_2(self, index, &all);
    if (result != V3_OK) return result;
    memset(info, 0, sizeof *info);
    memcpy(info->class_id, all.class_id, sizeof all.class_id);
    info->cardinality = all.cardinality;
    memcpy(info->category, all.category, sizeof all.category);
    memcpy(info->sub_categories, all.sub_categories, sizeof all.sub_categories);
    wide(all.name, info->name, 64), wide(all.vendor, info->vendor, 64);
    wide(all.version, info->version, 64), wide(all.sdk_version, info->sdk_version, 64);
    return V3_OK;
}
static v3_result V3_API set_context(void *self, struct v3_funknown **host) {
    (void)self, (void)host;
    return V3_OK;
}
static v3_result V3_API create(void *self, const v3_tuid id, const v3_tuid iid, void **to) {
    v3_tuid own;
    instance *object;
    v3_result result;
    (void)self;
    class_id(own);
    *to = NULL;
    if (!v3_tuid_match(id, own)) return V3_INVALID_ARG;
    if (!(object = (instance *)calloc(1, sizeof *object))) return V3_NOMEM;
    object->component = &component, object->processor = &processor, object->controller = &controller;
    object->mapping = &mapping, object->requirements = &requirements;
    atomic_init(&object->references, 1);
    object->channels = 1;
    voice_init(&object->voice, 0, bundle_presets_count);
    show(object, object->voice.applied);
    result = query(object, iid, to);
    release(object);
    return result;
}

V3_EXPORT const void *V3_API GetPluginFactory(void) {
    static const struct v3_plugin_factory_3 table = {
        factory_query, factory_ref, factory_ref, factory_info, class_count, class_info_1, create,
        class_info_2, class_info_3, set_context,
    };
    static const struct v3_plugin_factory_3 *factory = &table;
    return &factory;
}

/* what each system calls when it opens and closes a bundle */
#if defined __APPLE__
V3_EXPORT bool bundleEntry(void *bundle) { return (void)bundle, true; }
V3_EXPORT bool bundleExit(void) { return true; }
#elif defined _WIN32
V3_EXPORT bool InitDll(void) { return true; }
V3_EXPORT bool ExitDll(void) { return true; }
#else
V3_EXPORT bool ModuleEntry(void *library) { return (void)library, true; }
V3_EXPORT bool ModuleExit(void) { return true; }
#endif
