/* An LV2 host on lilv for the tests. Two instances play side by side; every block is checked as in
   plugin_host.h.

   lv2_host BUNDLE_URI NUMBER play RATE BLOCK FRAMES EVENTS OUT
   A row of kind 4 is the transport: 1 if it plays, and its seconds, or NaN to say no place.

   lv2_host BUNDLE_URI NUMBER probe    calls every function with what it must refuse or bear

   NUMBER: which plugin, in the order of their names. EVENTS: rows of kind (0 a control port, else
   MIDI), number (the port, or three bytes), frame, value; a port is set before the block that holds
   its frame, with all others as they were. OUT: the two outputs' samples in turn. */
#include "interposed.h"

#include <lilv/lilv.h>
#include <lv2/atom/atom.h>
#include <lv2/midi/midi.h>
#include <lv2/time/time.h>
#include <lv2/urid/urid.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PORTS = 64, LARGEST = 4096, GUARD = 16, EVENTS = 256, URIS = 32, INSTANCES = 2 };
typedef struct { int64_t kind, number, frame; double value; } row;
typedef struct { LV2_Atom_Event head; uint8_t data[8]; } midi_event;
typedef struct { LV2_Atom_Sequence head; midi_event events[EVENTS]; } midi_events;

static midi_events sequence;
static float controls[PORTS], out[INSTANCES][2][LARGEST + GUARD];

static void fail(const char *why) { fprintf(stderr, "%s\n", why), exit(3); }

static char *uris[URIS];
static LV2_URID map(LV2_URID_Map_Handle handle, const char *uri) {
    LV2_URID i;
    (void)handle;
    for (i = 0; i < URIS && uris[i]; i++)
        if (!strcmp(uris[i], uri)) return i + 1;
    if (i == URIS) fail("too many URIs");
    uris[i] = strdup(uri);
    return i + 1;
}
static LV2_URID_Map mapping = {NULL, map};
static const LV2_Feature feature = {LV2_URID__map, &mapping};
static const LV2_Feature *const features[] = {&feature, NULL};

static int by_name(const void *a, const void *b) {
    LilvNode *x = lilv_plugin_get_name(*(const LilvPlugin *const *)a);
    LilvNode *y = lilv_plugin_get_name(*(const LilvPlugin *const *)b);
    int order = strcmp(lilv_node_as_string(x), lilv_node_as_string(y));
    lilv_node_free(x), lilv_node_free(y);
    return order;
}

static void put_midi(uint32_t number, int64_t frame, uint32_t bytes) {
    midi_event *event = &sequence.events[number];
    int i;
    event->head.time.frames = frame;
    event->head.body.size = 3, event->head.body.type = map(NULL, LV2_MIDI__MidiEvent);
    for (i = 0; i < 3; i++) event->data[i] = (uint8_t)(bytes >> (16 - 8 * i));
}
/* The host's transport, an event that takes three places. */
static uint32_t put_position(uint32_t number, int64_t frame, double song, float speed) {
    struct { LV2_Atom_Event head; LV2_Atom_Object_Body body; LV2_Atom_Property_Body at; int64_t song;
             LV2_Atom_Property_Body runs; float speed, none; } event;
    memset(&event, 0, sizeof event);
    if (sizeof event != 3 * sizeof(midi_event)) fail("another size");
    event.head.time.frames = frame;
    event.head.body.size = sizeof event - sizeof event.head, event.head.body.type = map(NULL, LV2_ATOM__Object);
    event.body.otype = map(NULL, LV2_TIME__Position);
    event.at.key = map(NULL, isnan(song) ? LV2_TIME__bar : LV2_TIME__frame), event.at.value.size = 8, event.at.value.type = map(NULL, LV2_ATOM__Long);
    event.runs.key = map(NULL, LV2_TIME__speed), event.runs.value.size = 4, event.runs.value.type = map(NULL, LV2_ATOM__Float);
    event.song = isnan(song) ? 0 : (int64_t)(song < 0.0 ? song - 0.5 : song + 0.5), event.speed = speed;
    memcpy(&sequence.events[number], &event, sizeof event);
    return 3;
}
static void put_count(uint32_t events) {
    sequence.head.atom.type = map(NULL, LV2_ATOM__Sequence);
    sequence.head.atom.size = (uint32_t)(sizeof sequence.head.body + events * sizeof(midi_event));
}

static void run(LilvInstance *instance, float (*to)[LARGEST + GUARD], int64_t frames) {
    int i, n;
    for (i = 0; i < 2; i++)
        for (n = 0; n < LARGEST + GUARD; n++) to[i][n] = NAN;
    processing = 1;
    lilv_instance_run(instance, (uint32_t)frames);
    processing = 0;
    if (allocations) fail("allocated in run");
    for (i = 0; i < 2; i++)
        for (n = 0; n < LARGEST + GUARD; n++) {
            if (n >= frames && !isnan(to[i][n])) fail("written beyond the block");
            if (n < frames && to[i][n] != 0 && !isnormal(to[i][n])) fail("not a normal number");
        }
}

static void connect(LilvInstance *instance, float (*to)[LARGEST + GUARD], uint32_t ports) {
    uint32_t i;
    lilv_instance_connect_port(instance, 0, &sequence);
    for (i = 0; i < 2; i++) lilv_instance_connect_port(instance, 1 + i, to[i]);
    for (i = 3; i < ports; i++) lilv_instance_connect_port(instance, i, &controls[i]);
}

static int play(const LilvPlugin *plugin, char **given) {
    static float least[PORTS], most[PORTS];
    int64_t block = atol(given[1]), frames = atol(given[2]), done, n, next = 0, total, i;
    row *rows = (row *)calloc(1 << 16, sizeof *rows);
    LilvInstance *instances[INSTANCES];
    FILE *file = fopen(given[3], "rb");
    if (!file) fail(given[3]);
    total = (int64_t)fread(rows, sizeof *rows, 1 << 16, file), fclose(file);
    lilv_plugin_get_port_ranges_float(plugin, least, most, controls);
    for (i = 0; i < INSTANCES; i++) {
        instances[i] = lilv_plugin_instantiate(plugin, atof(given[0]), features);
        if (!instances[i]) fail("no instance");
        connect(instances[i], out[i], lilv_plugin_get_num_ports(plugin));
        lilv_instance_activate(instances[i]);
    }
    file = fopen(given[4], "wb");
    for (done = 0; done < frames; done += n) {
        uint32_t events = 0;
        n = frames - done < block ? frames - done : block;
        for (; next < total && rows[next].frame < done + n; next++)
            if (rows[next].kind == 0) controls[rows[next].number] = (float)rows[next].value;
            else if (rows[next].kind == 4)
                events += put_position(events, rows[next].frame - done, rows[next].value * atof(given[0]),
                                       (float)rows[next].number);
            else put_midi(events++, rows[next].frame - done, (uint32_t)rows[next].number);
        put_count(events);
        for (i = 0; i < INSTANCES; i++) run(instances[i], out[i], n);
        if (memcmp(out[0], out[1], sizeof out[0])) fail("two instances differ");
        for (i = 0; i < n; i++) fwrite(&out[0][0][i], 4, 1, file), fwrite(&out[0][1][i], 4, 1, file);
    }
    for (i = 0; i < INSTANCES; i++) lilv_instance_deactivate(instances[i]), lilv_instance_free(instances[i]);
    free(rows);
    return fclose(file);
}

static int probe(const LilvPlugin *plugin) {
    static const double rates[] = {NAN, INFINITY, -48000.0, 0.0, 5e-324, 999.9, 768001.0, 1e300};
    static const LV2_Feature *const none[] = {NULL};
    const uint32_t ports = lilv_plugin_get_num_ports(plugin), longest = UINT32_MAX;
    const LV2_Descriptor *table;
    LV2_Descriptor stranger = {.URI = "urn:nobody"};
    LilvInstance *instance = lilv_plugin_instantiate(plugin, 48000.0, features);
    uint32_t i, turn;
    size_t j;
    if (!instance) fail("no instance");
    table = lilv_instance_get_descriptor(instance);
    if (table->extension_data("urn:nothing") || table->extension_data("")) fail("gives what it hasn't");
    if (table->instantiate(table, 48000.0, "", NULL) || table->instantiate(table, 48000.0, "", none)) fail("needs no map");
    if (table->instantiate(&stranger, 48000.0, "", features)) fail("of any name");
    for (j = 0; j < sizeof rates / sizeof *rates; j++)
        if (table->instantiate(table, rates[j], "", features)) fail("plays at no rate");
    for (i = 0; i < 4; i++) lilv_instance_connect_port(instance, ports + (i << i * 8), controls);
    lilv_instance_connect_port(instance, UINT32_MAX, controls);
    for (turn = 0; turn < 3; turn++) {
        lilv_instance_activate(instance);
        /* nothing connected, then everything, then outputs no more */
        if (turn == 1) connect(instance, out[0], ports);
        for (i = 1; turn == 2 && i < 3; i++) lilv_instance_connect_port(instance, i, NULL);
        processing = 1;
        lilv_instance_run(instance, 64), lilv_instance_run(instance, 0), lilv_instance_run(instance, LARGEST);
        processing = 0;
        lilv_instance_deactivate(instance);
    }
    connect(instance, out[0], ports), lilv_instance_activate(instance);
    for (turn = 0; turn < 2000; turn++) {
        uint32_t events = (uint32_t)rand() % 8;
        for (i = 0; i < events; i++) {
            put_midi(i, rand() % 100 - 20, (uint32_t)rand());
            if (rand() % 4 == 0) sequence.events[i].head.time.frames = rand() % 2 ? INT64_MIN : INT64_MAX;
            if (rand() % 4 == 0) sequence.events[i].head.body.size = (uint32_t)rand() % 12;
            if (rand() % 4 == 0) sequence.events[i].head.body.type = (uint32_t)rand();
            if (rand() % 16 == 0) sequence.events[i].head.body.size = longest - (uint32_t)rand() % 12;
        }
        put_count(events);
        if (rand() % 4 == 0) sequence.head.atom.size = (uint32_t)rand() % (8 + 8 * 24);
        run(instance, out[0], 64);
    }
    lilv_instance_deactivate(instance), lilv_instance_free(instance);
    if (allocations) fail("allocated in run");
    return 0;
}

int main(int count, char **given) {
    LilvWorld *world = lilv_world_new();
    const LilvPlugin *found[16];
    LilvNode *bundle;
    int plugins = 0, result, which = count > 3 ? atoi(given[2]) : 0;
    if (count != 9 && count != 4) fail("usage");
    lilv_world_load_specifications(world);
    bundle = lilv_new_uri(world, given[1]);
    lilv_world_load_bundle(world, bundle);
    LILV_FOREACH(plugins, at, lilv_world_get_all_plugins(world))
        found[plugins++] = lilv_plugins_get(lilv_world_get_all_plugins(world), at);
    qsort(found, (size_t)plugins, sizeof *found, by_name);
    if (which >= plugins || !lilv_plugin_verify(found[which])) fail("no such plugin, or not valid");
    result = count == 4 ? probe(found[which]) : play(found[which], given + 4);
    lilv_node_free(bundle);
    lilv_world_free(world);
    return result;
}
