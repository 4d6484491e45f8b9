/* Every function of a CLAP plugin, called with what it must refuse or bear. */
static void probe_params(void) {
    const clap_plugin_t *p = plugins[0];
    static const char *const texts[] = {"", " ", "nan", "-nan", "inf", "-inf", "1e999", "-1e999", "0x", "%n%s", "\xff\xfe", "viscous "};
    static clap_param_info_t info;
    uint32_t i, n = params->count(p), j, size;
    char text[64];
    double value;
    if (params->get_info(p, n, &info) || params->get_info(p, UINT32_MAX, &info)) fail("a parameter too many");
    if (params->get_value(p, 12345, &value) || params->value_to_text(p, 12345, 0.0, text, 64)
        || params->text_to_value(p, 12345, "0", &value)) fail("a parameter that isn't there");
    for (i = 0; i < n; i++) {
        if (!params->get_info(p, i, &info)) fail("no parameter");
        for EACH(j, wild) {
            row said = {KIND_VALUE, info.id, 0, wild[j]};
            list one = {&said, 1, 0};
            host_flush(0, &one);
            if (!params->get_value(p, info.id, &value)) fail("no value");
            if (!(value >= info.min_value && value <= info.max_value)) fail("a value out of its range");
            for (size = 0; size < 8; size++) {
                memset(text, '#', sizeof text);
                if (params->value_to_text(p, info.id, wild[j], text, size)
                    != (size && wild[j] >= info.min_value && wild[j] <= info.max_value)) fail("text of no value");
                if (text[size] != '#' || (text[0] != '#' && !memchr(text, 0, size))) fail("text beyond its room");
            }
        }
        for EACH(j, texts)
            if (params->text_to_value(p, info.id, texts[j], &value) && !(value >= info.min_value && value <= info.max_value))
                fail(texts[j]);
    }
}

static void host_probe(void) {
    const clap_plugin_t *p = plugins[0];
    const clap_plugin_audio_ports_t *audio = p->get_extension(p, CLAP_EXT_AUDIO_PORTS);
    const clap_plugin_note_ports_t *notes = p->get_extension(p, CLAP_EXT_NOTE_PORTS);
    static clap_audio_port_info_t port;
    static clap_note_port_info_t keys;
    static float out[2][LARGEST];
    static const list none = {NULL, 0, 0};
    uint32_t i, direction;
    clap_process_t empty = {.frames_count = 64, .out_events = &nowhere};
    clap_input_events_t in = {(void *)(uintptr_t)&none, events_size, events_get};
    if (entry->get_factory("nothing") || factory->get_plugin_descriptor(factory, 1)
        || factory->create_plugin(factory, &host, "nothing") || p->get_extension(p, "clap.nothing")
        || p->get_extension(p, "")) fail("gives what isn't there");
    for (direction = 0; direction < 2; direction++)
        for (i = 0; i < 5; i++) {
            const uint32_t index = i < 4 ? i : UINT32_MAX;
            if (audio->get(p, index, direction, &port) != (index < audio->count(p, direction))) fail("not that many outputs");
            if (notes->get(p, index, direction, &keys) != (index < notes->count(p, direction))) fail("not that many inputs");
        }
    if (host_latency() != 0 || host_tail() != 0 || p->start_processing(p)) fail("active before it is");
    if (host_process(0, &none, 64, out[0], out[1]) != CLAP_PROCESS_ERROR) fail("plays before it is active");
    host_reset(0), p->on_main_thread(p), probe_params();
    for EACH(i, wild_rates)
        if (host_activate(0, wild_rates[i])) fail("active at no rate");
    for (i = 0; i < 3; i++) {
        if (!host_activate(0, 48000.0)) fail("not activated");
        probe_params(), host_reset(0), p->on_main_thread(p);
        /* without outputs, without events, without frames */
        if (p->process(p, &empty) == CLAP_PROCESS_ERROR) fail("not processed");
        empty.in_events = &in, empty.frames_count = 0;
        if (p->process(p, &empty) == CLAP_PROCESS_ERROR) fail("not processed");
        p->stop_processing(p), p->deactivate(p);
    }
    if (allocations) fail("allocated in the audio thread");
}
