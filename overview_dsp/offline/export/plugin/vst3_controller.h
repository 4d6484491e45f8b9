/* An instance of the VST3 plugin, and what a host asks of its parameters. */
#ifndef OVERVIEW_VST3_CONTROLLER_H
#define OVERVIEW_VST3_CONTROLLER_H
#include "state.h"
#include "vst3.h"

/* MIDI controllers come as parameters: the modulation wheel, and all notes off. */
enum { PARAMETER_WHEEL = VOICE_VALUES, PARAMETER_RELEASE, PARAMETERS };

/* One object with a face (a table of functions) for each interface. */
typedef struct {
    const struct v3_component *component;
    const struct v3_audio_processor *processor;
    const struct v3_edit_controller *controller;
    const struct v3_midi_mapping *mapping;
    const struct v3_process_context_requirements *requirements;
    _Atomic uint32_t references;
    double rate; /* 0: not set up */
    int channels; /* of the first output: the click, or the click and the tactor */
    int wheel; /* where it was last, 0 to 127 */
    double shown[PARAMETERS]; /* the main thread's: normalised */
    voice voice;
} instance;
#define OF(self, face) ((instance *)((char *)(self) - offsetof(instance, face)))

/* ---- text: UTF-8 here, UTF-16 there */

static void wide(const char *text, int16_t *to, int room) {
    const uint8_t *at = (const uint8_t *)text;
    while (*at && room > 2) {
        int more = *at >= 0xF0 ? 3 : *at >= 0xE0 ? 2 : *at >= 0xC0 ? 1 : 0;
        uint32_t point = *at++ & (more == 3 ? 7u : more == 2 ? 15u : more == 1 ? 31u : 127u);
        for (; more && (*at & 0xC0) == 0x80; more--) point = point << 6 | (*at++ & 63u);
        if (point > 0xFFFF) {
            *to++ = (int16_t)(0xD800 + ((point - 0x10000) >> 10)), room--;
            point = 0xDC00 + (point & 0x3FF);
        }
        *to++ = (int16_t)point, room--;
    }
    *to = 0;
}
static void narrow(const int16_t *text, char *to, int room) {
    for (; *text && room > 4; text++) {
        uint32_t point = (uint16_t)*text;
        int more;
        if (point >= 0xD800 && point < 0xDC00 && text[1])
            point = 0x10000 + ((point & 0x3FF) << 10) + ((uint16_t)*++text & 0x3FF);
        more = point > 0xFFFF ? 3 : point > 0x7FF ? 2 : point > 0x7F ? 1 : 0;
        *to++ = (char)(more ? (0xF00 >> more & 0xFF) | point >> 6 * more : point);
        room -= 1 + more;
        while (more--) *to++ = (char)(0x80 | (point >> 6 * more & 63));
    }
    *to = 0;
}

/* ---- parameters: numbers from 0 to 1 to the host */

static v3_param_id parameter_number(int which) {
    return which < VOICE_VALUES ? value_number(which) & INT32_MAX : (v3_param_id)(which - VOICE_VALUES);
}
static int parameter_of(v3_param_id number) {
    return number < PARAMETERS - VOICE_VALUES ? VOICE_VALUES + (int)number : value_of(number, INT32_MAX);
}
static double plain_shown(instance *self, int which, double normal) {
    double known[VOICE_VALUES];
    int i;
    if (which >= VOICE_VALUES) return normal;
    for (i = 0; i < VOICE_VALUES; i++) known[i] = atomic_load(&self->voice.values[i]);
    return value_plain(&self->voice, which, normal, known);
}
static void show(instance *self, const double values[VOICE_VALUES]) {
    int which;
    for (which = 0; which < VOICE_VALUES; which++)
        self->shown[which] = value_normal(&self->voice, which, values[which]);
}

static int32_t V3_API parameter_count(void *self) {
    (void)self;
    return PARAMETERS;
}
static v3_result V3_API parameter_info(void *self, int32_t which, struct v3_param_info *info) {
    const voice *v = &OF(self, controller)->voice;
    int own = which < VOICE_VALUES;
    if (which < 0 || which >= PARAMETERS) return V3_INVALID_ARG;
    memset(info, 0, sizeof *info);
    info->param_id = parameter_number(which);
    wide(own ? value_name(which) : which == PARAMETER_WHEEL ? "Modulation wheel" : "All notes off", info->title, 128);
    memcpy(info->short_title, info->title, sizeof info->title);
    info->flags = V3_PARAM_CAN_AUTOMATE;
    if (!own || value_is_hidden(v, which)) info->flags |= V3_PARAM_IS_HIDDEN;
    if (!own) return V3_OK;
    wide(value_unit(which), info->units, 128);
    if (voice_is_choice(which)) info->step_count = (int32_t)voice_highest(v, which);
    if (info->step_count > 1) info->flags |= V3_PARAM_IS_LIST;
    info->default_normalised_value = value_normal(v, which, voice_default(v, which));
    return V3_OK;
}
static v3_result V3_API parameter_text(void *self, v3_param_id id, double normal, v3_str_128 text) {
    instance *object = OF(self, controller);
    int which = parameter_of(id);
    char said[512]; /* for 128 characters of any length */
    if (which < 0 || normal != normal) return V3_INVALID_ARG;
    if (which >= VOICE_VALUES) snprintf(said, sizeof said, "%.9g", normal);
    else if (!value_to_text(&object->voice, which, plain_shown(object, which, normal), said, sizeof said))
        return V3_INVALID_ARG;
    wide(said, text, 128);
    return V3_OK;
}
static v3_result V3_API parameter_from_text(void *self, v3_param_id id, int16_t *text, double *normal) {
    voice *v = &OF(self, controller)->voice;
    int which = parameter_of(id);
    char said[512];
    double plain;
    if (which < 0 || which >= VOICE_VALUES) return V3_INVALID_ARG;
    narrow(text, said, sizeof said);
    if (!value_from_text(v, which, said, &plain)) return V3_FALSE;
    *normal = value_normal(v, which, plain);
    return V3_OK;
}
static double V3_API parameter_plain(void *self, v3_param_id id, double normal) {
    int which = parameter_of(id);
    return which < 0 ? normal : plain_shown(OF(self, controller), which, normal);
}
static double V3_API parameter_normal(void *self, v3_param_id id, double plain) {
    int which = parameter_of(id);
    return which < 0 || which >= VOICE_VALUES ? plain : value_normal(&OF(self, controller)->voice, which, plain);
}
static double V3_API parameter_get(void *self, v3_param_id id) {
    int which = parameter_of(id);
    return which < 0 ? 0.0 : OF(self, controller)->shown[which];
}
/* Only shown: the audio thread is told by the host. */
static v3_result V3_API parameter_set(void *self, v3_param_id id, double normal) {
    int which = parameter_of(id);
    if (which < 0 || !(normal >= 0.0 && normal <= 1.0)) return V3_INVALID_ARG;
    OF(self, controller)->shown[which] = normal;
    return V3_OK;
}

static v3_result V3_API controller_assignment(
    void *self, int32_t bus, int16_t channel, int16_t number, v3_param_id *id) {
    (void)self, (void)channel;
    if (bus != 0 || (number != 1 && number != 120 && number != 123)) return V3_FALSE;
    *id = parameter_number(number == 1 ? PARAMETER_WHEEL : PARAMETER_RELEASE);
    return V3_OK;
}

/* ---- state */

static int stream_state(const voice *v, struct v3_bstream **stream, state_values *read) {
    char bytes[STATE_MOST + 1];
    int32_t done = 0, n;
    while (done < (int32_t)sizeof bytes) {
        n = 0;
        if ((*stream)->read(stream, bytes + done, (int32_t)sizeof bytes - done, &n) != V3_OK || n <= 0) break;
        if (n > (int32_t)sizeof bytes - done) return 0;
        done += n;
    }
    return state_read(v, bytes, (size_t)done, read);
}
static v3_result V3_API component_state(void *self, struct v3_bstream **stream) {
    state_values read;
    if (!stream_state(&OF(self, controller)->voice, stream, &read)) return V3_FALSE;
    show(OF(self, controller), read.values);
    return V3_OK;
}
/* The component's state is the whole. */
static v3_result V3_API controller_state(void *self, struct v3_bstream **stream) {
    (void)self, (void)stream;
    return V3_OK;
}
static v3_result V3_API set_handler(void *self, struct v3_component_handler **handler) {
    (void)self, (void)handler;
    return V3_OK;
}
static struct v3_plugin_view **V3_API create_view(void *self, const char *name) {
    (void)self, (void)name;
    return NULL;
}

#endif
