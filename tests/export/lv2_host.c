/* An LV2 host on lilv for the tests: lv2_host BUNDLE_URI NUMBER RATE BLOCK FRAMES EVENTS OUT

   NUMBER: which plugin, in the order of their names. EVENTS: rows of kind (0 a control port, else
   MIDI), number (the port, or three bytes), frame, value; a port is set before the block that holds
   its frame, with all others as they were. OUT: the two outputs' samples in turn. */
#include "interposed.h"

#include <lilv/lilv.h>
#include <lv2/atom/atom.h>
#include <lv2/midi/midi.h>
#include <lv2/urid/urid.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PORTS = 64, LARGEST = 4096, EVENTS = 256, URIS = 32 };
typedef struct { int64_t kind, number, frame; double value; } row;
typedef struct { LV2_Atom_Event head; uint8_t data[8]; } midi_event;

static char *uris[URIS];
static LV2_URID map(LV2_URID_Map_Handle handle, const char *uri) {
    LV2_URID i;
    (void)handle;
    for (i = 0; i < URIS && uris[i]; i++)
        if (!strcmp(uris[i], uri)) return i + 1;
    if (i == URIS) exit(3);
    uris[i] = strdup(uri);
    return i + 1;
}

static int by_name(const void *a, const void *b) {
    LilvNode *x = lilv_plugin_get_name(*(const LilvPlugin *const *)a);
    LilvNode *y = lilv_plugin_get_name(*(const LilvPlugin *const *)b);
    int order = strcmp(lilv_node_as_string(x), lilv_node_as_string(y));
    lilv_node_free(x), lilv_node_free(y);
    return order;
}

int main(int count, char **given) {
    static struct { LV2_Atom_Sequence head; midi_event events[EVENTS]; } sequence;
    static float controls[PORTS], least[PORTS], most[PORTS], out[2][LARGEST];
    static LV2_URID_Map mapping = {NULL, map};
    static const LV2_Feature feature = {LV2_URID__map, &mapping};
    const LV2_Feature *features[] = {&feature, NULL};
    LilvWorld *world = lilv_world_new();
    const LilvPlugin *found[16], *plugin;
    LilvInstance *instance;
    LilvNode *bundle;
    int64_t block, frames, done, n, next = 0, total, i;
    row *rows = (row *)calloc(1 << 16, sizeof *rows);
    int plugins = 0;
    FILE *file;
    if (count != 8 || !(file = fopen(given[6], "rb"))) return 3;
    total = (int64_t)fread(rows, sizeof *rows, 1 << 16, file), fclose(file);
    block = atol(given[4]), frames = atol(given[5]);
    lilv_world_load_specifications(world);
    bundle = lilv_new_uri(world, given[1]);
    lilv_world_load_bundle(world, bundle);
    LILV_FOREACH(plugins, at, lilv_world_get_all_plugins(world))
        found[plugins++] = lilv_plugins_get(lilv_world_get_all_plugins(world), at);
    qsort(found, (size_t)plugins, sizeof *found, by_name);
    if (atoi(given[2]) >= plugins) return fprintf(stderr, "%d plugins\n", plugins), 4;
    plugin = found[atoi(given[2])];
    if (!lilv_plugin_verify(plugin)) return fprintf(stderr, "not valid\n"), 4;
    instance = lilv_plugin_instantiate(plugin, atof(given[3]), features);
    if (!instance) return fprintf(stderr, "no instance\n"), 4;
    lilv_plugin_get_port_ranges_float(plugin, least, most, controls);
    lilv_instance_connect_port(instance, 0, &sequence);
    for (i = 0; i < 2; i++) lilv_instance_connect_port(instance, 1 + (uint32_t)i, out[i]);
    for (i = 3; i < lilv_plugin_get_num_ports(plugin); i++)
        lilv_instance_connect_port(instance, (uint32_t)i, &controls[i]);
    lilv_instance_activate(instance);
    file = fopen(given[7], "wb");
    for (done = 0; done < frames; done += n) {
        uint32_t events = 0;
        n = frames - done < block ? frames - done : block;
        for (; next < total && rows[next].frame < done + n; next++)
            if (rows[next].kind == 0) controls[rows[next].number] = (float)rows[next].value;
            else {
                midi_event *event = &sequence.events[events++];
                event->head.time.frames = rows[next].frame - done;
                event->head.body.size = 3, event->head.body.type = map(NULL, LV2_MIDI__MidiEvent);
                for (i = 0; i < 3; i++) event->data[i] = (uint8_t)(rows[next].number >> (16 - 8 * i));
            }
        sequence.head.atom.type = map(NULL, LV2_ATOM__Sequence);
        sequence.head.atom.size = (uint32_t)(sizeof sequence.head.body + events * sizeof(midi_event));
        processing = 1;
        lilv_instance_run(instance, (uint32_t)n);
        processing = 0;
        if (allocations) return fprintf(stderr, "allocated in run\n"), 5;
        for (i = 0; i < n; i++) fwrite(&out[0][i], 4, 1, file), fwrite(&out[1][i], 4, 1, file);
    }
    lilv_instance_deactivate(instance);
    lilv_instance_free(instance);
    lilv_node_free(bundle);
    lilv_world_free(world);
    return fclose(file);
}
