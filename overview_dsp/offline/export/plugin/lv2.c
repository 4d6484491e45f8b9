/* A bundle as LV2 plugins, one a preset: two outputs, MIDI, and a control port for each value. */
#include "lv2.h"
#include "voice.h"

/* Ports, as in the bundle's Turtle file, the last one where there are several timelines: of the
   values all but the preset. */
enum { PORT_EVENTS, PORT_CLICK, PORT_TACTOR, PORT_THETA2, PORT_TOUCH, PORT_FOLLOW, PORT_OWN, MOST_PRESETS = 64 };
enum { PORT_TIMELINE = PORT_OWN + OVERVIEW_PARAMETERS, PORTS };

typedef struct {
    void *ports[PORTS];
    float heard[PORTS]; /* what the controls were */
    int fresh; /* no block since it was activated */
    LV2_URID midi, object, position, frame, speed;
    voice voice;
} instance;

static int value_at(int port) {
    if (port == PORT_TIMELINE) return VOICE_TIMELINE;
    if (port == PORT_FOLLOW) return VOICE_FOLLOW;
    return port < PORT_OWN ? port - PORT_THETA2 + VOICE_THETA2 : port - PORT_OWN + VOICE_OWN;
}

/* A port's value; a preset's own, rounded to a float on its way through the host, is its own. */
static double control(const instance *self, int port) {
    float value = *(const float *)self->ports[port];
    double own = voice_default(&self->voice, value_at(port));
    return value == (float)own ? own : value;
}

static LV2_Handle instantiate(const LV2_Descriptor *descriptor, double rate, const char *path,
                              const LV2_Feature *const *features) {
    const LV2_URID_Map *map = NULL;
    instance *self;
    int preset = 0;
    (void)path;
    while (preset < bundle_presets_count && strcmp(bundle_presets[preset].uri, descriptor->URI)) preset++;
    for (; features && *features; features++)
        if (!strcmp((*features)->URI, LV2_URID__map)) map = (const LV2_URID_Map *)(*features)->data;
    if (!map || preset == bundle_presets_count) return NULL;
    if (!(self = (instance *)calloc(1, sizeof *self))) return NULL;
    self->midi = map->map(map->handle, LV2_MIDI__MidiEvent);
    self->object = map->map(map->handle, LV2_ATOM__Object);
    self->position = map->map(map->handle, LV2_TIME__Position);
    self->frame = map->map(map->handle, LV2_TIME__frame);
    self->speed = map->map(map->handle, LV2_TIME__speed);
    voice_init(&self->voice, preset, 1);
    if (!voice_activate(&self->voice, rate)) return self;
    free(self);
    return NULL;
}
static void cleanup(LV2_Handle handle) {
    voice_deactivate(&((instance *)handle)->voice);
    free(handle);
}
static void connect_port(LV2_Handle handle, uint32_t port, void *data) {
    if (port < PORTS) ((instance *)handle)->ports[port] = data;
}
/* A host tells where its transport is as it starts, stops and jumps. `body`: of an atom object. */
static void hear_position(instance *self, const char *body, uint32_t size, int32_t at) {
    voice *v = &self->voice;
    const char *next = body + sizeof(LV2_Atom_Object_Body);
    double seconds = (double)(v->song + (v->is_playing ? at : 0)) / v->rate; /* if it says no place */
    int is_playing = v->is_playing;
    if (size < sizeof(LV2_Atom_Object_Body) || ((const LV2_Atom_Object_Body *)body)->otype != self->position) return;
    while (next + sizeof(LV2_Atom_Property_Body) <= body + size) {
        const LV2_Atom_Property_Body *property = (const LV2_Atom_Property_Body *)next;
        const char *value = (const char *)(property + 1);
        if (property->value.size > (size_t)(body + size - value)) return;
        if (property->key == self->frame && property->value.size == 8) {
            int64_t frame;
            memcpy(&frame, value, 8);
            seconds = (double)frame / v->rate;
        } else if (property->key == self->speed && property->value.size == 4) {
            float speed;
            memcpy(&speed, value, 4);
            is_playing = speed > 0.0f;
        }
        next = value + ((property->value.size + 7u) & ~7u);
    }
    if (at > v->done) voice_run(v, at);
    voice_transport(v, seconds, is_playing, at);
    if (!v->is_playing) v->song += at; /* it stays there */
}
static void activate(LV2_Handle handle) { ((instance *)handle)->fresh = 1; }
static void deactivate(LV2_Handle handle) { (void)handle; }

static void run(LV2_Handle handle, uint32_t frames) {
    instance *self = (instance *)handle;
    voice *v = &self->voice;
    const LV2_Atom_Sequence *events = (const LV2_Atom_Sequence *)self->ports[PORT_EVENTS];
    int port;
    if (self->fresh) {
        /* a voice that begins has its values, and glides to none */
        for (port = PORT_THETA2; port < PORTS; port++)
            if (self->ports[port]) voice_keep(v, value_at(port), control(self, port));
        voice_restart(v);
    }
    voice_begin(v, (float *)self->ports[PORT_CLICK], (float *)self->ports[PORT_TACTOR]);
    for (port = PORT_THETA2; port < PORTS; port++) {
        float value = self->ports[port] ? *(const float *)self->ports[port] : 0.0f;
        if (!self->fresh && self->ports[port] && value != self->heard[port])
            voice_set(v, value_at(port), control(self, port), 0);
        self->heard[port] = value;
    }
    self->fresh = 0;
    if (events) {
        const char *at = (const char *)(events + 1), *end = (const char *)&events->body + events->atom.size;
        int32_t frame = 0;
        while (at + sizeof(LV2_Atom_Event) <= end) {
            const LV2_Atom_Event *event = (const LV2_Atom_Event *)at;
            const uint8_t *data = (const uint8_t *)(event + 1);
            if (event->body.size > (size_t)(end - (const char *)data)) break;
            if (event->time.frames > frame)
                frame = event->time.frames < frames ? (int32_t)event->time.frames : (int32_t)frames;
            if (event->body.type == self->object)
                hear_position(self, (const char *)data, event->body.size, frame);
            if (event->body.type == self->midi && event->body.size >= 3) voice_midi(v, data, frame);
            at += sizeof(LV2_Atom_Event) + ((event->body.size + 7u) & ~7u);
        }
    }
    voice_run(v, (int32_t)frames);
    if (v->is_playing) v->song += frames; /* a host says only where it starts, stops and jumps */
}

static const void *extension_data(const char *uri) {
    (void)uri;
    return NULL;
}

LV2_SYMBOL_EXPORT const LV2_Descriptor *lv2_descriptor(uint32_t index) {
    static LV2_Descriptor all[MOST_PRESETS];
    if (index >= (uint32_t)bundle_presets_count) return NULL;
    all[index] = (LV2_Descriptor){bundle_presets[index].uri, instantiate, connect_port, activate,
                                  run, deactivate, cleanup, extension_data};
    return &all[index];
}
