/* Every function of a VST3 plugin, called with what it must refuse or bear. */
static v3_result V3_API broken_io(void *self, void *bytes, int32_t size, int32_t *done) {
    (void)self, (void)bytes, (void)size, *done = 0;
    return V3_INVALID_ARG;
}
static const struct v3_bstream broken_table = {host_query, host_ref, host_ref, broken_io, broken_io, NULL, NULL};

static void probe_parameters(void) {
    struct v3_edit_controller const **c = controllers[0];
    static const int16_t texts[][8] = {{0}, {' ', 0}, {'n', 'a', 'n', 0}, {'-', 'i', 'n', 'f', 0}, {'1', 'e', '9', '9', '9', 0},
                                       {(int16_t)0xD800, 0}, {(int16_t)0xDC00, 'x', 0}, {(int16_t)0xD83D, (int16_t)0xDE00, 0}};
    struct v3_param_info info;
    v3_str_128 text;
    int16_t again[8];
    double value;
    size_t j;
    int32_t i, n = (*c)->get_parameter_count(c);
    if (!(*c)->get_parameter_info(c, -1, &info) || !(*c)->get_parameter_info(c, n, &info)
        || !(*c)->get_parameter_info(c, INT32_MIN, &info) || !(*c)->get_parameter_info(c, INT32_MAX, &info))
        fail("a parameter too many");
    if (!(*c)->get_parameter_string_for_value(c, 12345, 0.0, text) || !(*c)->set_parameter_normalised(c, 12345, 0.0)
        || (*c)->get_parameter_normalised(c, 12345) != 0.0) fail("a parameter that isn't there");
    for (i = 0; i < n; i++) {
        double low, high;
        if ((*c)->get_parameter_info(c, i, &info)) fail("no parameter");
        low = (*c)->normalised_parameter_to_plain(c, info.param_id, 0.0);
        high = (*c)->normalised_parameter_to_plain(c, info.param_id, 1.0);
        for EACH(j, wild) {
            const bool inside = wild[j] >= 0.0 && wild[j] <= 1.0;
            row said = {KIND_VALUE, info.param_id, 0, wild[j]};
            list one = {&said, 1, 0};
            host_flush(0, &one);
            if (((*c)->set_parameter_normalised(c, info.param_id, wild[j]) == V3_OK) != inside) fail("set to no value");
            value = (*c)->get_parameter_normalised(c, info.param_id);
            if (!(value >= 0.0 && value <= 1.0)) fail("shows no value");
            value = (*c)->normalised_parameter_to_plain(c, info.param_id, wild[j]);
            if (inside && !(value >= low && value <= high)) fail("a value out of its range");
            if (inside && (*c)->get_parameter_string_for_value(c, info.param_id, wild[j], text)) fail("no text");
        }
        for EACH(j, texts) {
            memcpy(again, texts[j], sizeof again);
            if (info.param_id > 1 && (*c)->get_parameter_value_for_string(c, info.param_id, again, &value) == V3_OK
                && !(value >= 0.0 && value <= 1.0)) fail("text of no value");
        }
    }
}

static void probe_buses(void) {
    struct v3_component const **c = components[0];
    struct v3_bus_info bus;
    v3_speaker_arrangement arrangement;
    int32_t type, direction, index;
    for (type = -1; type < 4; type++)
        for (direction = -1; direction < 4; direction++)
            for (index = -1; index < 4; index++) {
                const bool is = index >= 0 && index < (*c)->get_bus_count(c, type, direction);
                if (((*c)->get_bus_info(c, type, direction, index, &bus) == V3_OK) != is) fail("not that many buses");
                if (((*c)->activate_bus(c, type, direction, index, 1) == V3_OK) != is) fail("not that many buses");
                if (type == V3_AUDIO && ((*processors[0])->get_bus_arrangement(processors[0], direction, index, &arrangement) == V3_OK) != is)
                    fail("not that many arrangements");
            }
}

static void probe_arrangements(void) {
    static const struct { int inputs, outputs; v3_speaker_arrangement of[3]; } refused[] = {
        {1, 1, {V3_SPEAKER_M}}, {0, 0, {0}}, {0, -1, {0}}, {0, 3, {V3_SPEAKER_M, V3_SPEAKER_M, V3_SPEAKER_M}},
        {0, 1, {0}}, {0, 1, {UINT64_MAX}}, {0, 1, {7}}, {0, 2, {V3_SPEAKER_M, V3_SPEAKER_L | V3_SPEAKER_R}}};
    size_t i;
    for EACH(i, refused) {
        v3_speaker_arrangement given[3];
        memcpy(given, refused[i].of, sizeof given);
        if ((*processors[0])->set_bus_arrangements(processors[0], given, refused[i].inputs, given, refused[i].outputs) == V3_OK)
            fail("outputs that it hasn't");
    }
}

static void host_probe(void) {
    struct v3_component const **c = components[0];
    struct v3_audio_processor const **p = processors[0];
    struct v3_midi_mapping const **mapping;
    struct v3_process_context_requirements const **requirements;
    static const struct v3_bstream *broken = &broken_table;
    struct v3_process_setup setup = {0, V3_SAMPLE_64, LARGEST, 48000.0};
    struct v3_process_data empty = {.symbolic_sample_size = V3_SAMPLE_32};
    struct v3_audio_bus_buffers hollow[3] = {{.num_channels = 1}, {.num_channels = 0}, {.num_channels = 0}};
    static float spare[3][64], *channels[3] = {spare[0], spare[1], spare[2]};
    struct v3_audio_bus_buffers wide = {.num_channels = 3, .channel_buffers_32 = channels};
    struct v3_class_info info;
    struct v3_class_info_2 more;
    struct v3_class_info_3 most;
    struct v3_factory_info maker;
    v3_param_id id;
    v3_tuid nobody = {0};
    void *none = &none;
    size_t i;
    int32_t at, turn;
    for (at = -1; at < 2; at++) {
        const bool is = at == 0;
        if (((*factory)->get_class_info(factory, at, &info) == V3_OK) != is
            || ((*factory)->get_class_info_2(factory, at, &more) == V3_OK) != is
            || ((*factory)->get_class_info_utf16(factory, at, &most) == V3_OK) != is) fail("not one class");
    }
    if ((*factory)->get_factory_info(factory, &maker) || !*maker.vendor) fail("no maker");
    if ((*factory)->query_interface(factory, nobody, &none) != V3_NO_INTERFACE || none) fail("any interface");
    if ((*factory)->create_instance(factory, class_info.class_id, nobody, &none) == V3_OK || none) fail("an instance of any kind");
    if ((*c)->query_interface(c, nobody, &none) != V3_NO_INTERFACE || none) fail("any interface");
    if ((*c)->query_interface(c, v3_midi_mapping_iid, (void **)&mapping)
        || (*c)->query_interface(c, v3_process_context_requirements_iid, (void **)&requirements)) fail("no interface");
    for (at = -2; at < 140; at++) {
        const bool is = at == 1 || at == 120 || at == 123;
        if (((*mapping)->get_midi_controller_assignment(mapping, 0, 15, (int16_t)at, &id) == V3_OK) != is
            || (*mapping)->get_midi_controller_assignment(mapping, 1, 0, (int16_t)at, &id) == V3_OK) fail("a controller");
    }
    (*requirements)->get_process_context_requirements(requirements);
    (*mapping)->unref(mapping), (*requirements)->unref(requirements);
    probe_buses(), probe_arrangements();
    if ((*c)->set_state(c, (struct v3_bstream **)(void *)&broken) == V3_OK
        || (*c)->get_state(c, (struct v3_bstream **)(void *)&broken) == V3_OK) fail("a broken stream is good");
    if ((*controllers[0])->create_view(controllers[0], "editor")) fail("a window");
    if (host_latency() != 0 || host_tail() != 0 || (*c)->set_active(c, 1) == V3_OK) fail("active before it is");
    empty.nframes = 64;
    if ((*p)->process(p, &empty) == V3_OK) fail("plays before it is active");
    if ((*p)->can_process_sample_size(p, V3_SAMPLE_64) == V3_OK || (*p)->setup_processing(p, &setup) == V3_OK) fail("doubles");
    setup.symbolic_sample_size = V3_SAMPLE_32;
    probe_parameters();
    for EACH(i, wild_rates) {
        setup.sample_rate = wild_rates[i];
        if ((*p)->setup_processing(p, &setup) == V3_OK && (*c)->set_active(c, 1) == V3_OK) fail("active at no rate");
    }
    for (turn = 0; turn < 3; turn++) {
        if (!host_activate(0, 48000.0)) fail("not activated");
        probe_parameters();
        empty = (struct v3_process_data){.symbolic_sample_size = V3_SAMPLE_64, .nframes = 64};
        if ((*p)->process(p, &empty) == V3_OK) fail("doubles");
        /* without outputs, with hollow ones, with more than there are, for less than nothing */
        empty.symbolic_sample_size = V3_SAMPLE_32;
        if ((*p)->process(p, &empty) != V3_OK) fail("not processed");
        empty.num_output_buses = 3, empty.outputs = hollow;
        if ((*p)->process(p, &empty) != V3_OK) fail("not processed");
        empty.num_output_buses = 1, empty.outputs = &wide, spare[2][63] = 1.0f;
        if ((*p)->process(p, &empty) != V3_OK || spare[2][63] != 0.0f) fail("not processed");
        empty.nframes = -1;
        if ((*p)->process(p, &empty) != V3_OK) fail("not processed");
        host_reset(0);
        if ((*p)->set_processing(p, 0) || (*c)->set_active(c, 0)) fail("not deactivated");
    }
    active[0] = false;
    if (allocations) fail("allocated in the audio thread");
}
