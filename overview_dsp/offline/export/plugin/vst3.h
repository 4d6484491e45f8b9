/* The VST3 interfaces that an instrument without a window implements, as plain C: from "travesty", the
   pure C VST3-compatible headers of DPF (https://github.com/DISTRHO/DPF), without comments and C++,
   with its structs' unnamed members written out as macros.

   Copyright (C) 2021-2022 Filipe Coelho <falktx@falktx.com>

   Permission to use, copy, modify, and/or distribute this software for any purpose with
   or without fee is hereby granted, provided that the above copyright notice and this
   permission notice appear in all copies.

   THE SOFTWARE IS PROVIDED "AS IS" AND THE AUTHOR DISCLAIMS ALL WARRANTIES WITH REGARD
   TO THIS SOFTWARE INCLUDING ALL IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS. IN
   NO EVENT SHALL THE AUTHOR BE LIABLE FOR ANY SPECIAL, DIRECT, INDIRECT, OR CONSEQUENTIAL
   DAMAGES OR ANY DAMAGES WHATSOEVER RESULTING FROM LOSS OF USE, DATA OR PROFITS, WHETHER
   IN AN ACTION OF CONTRACT, NEGLIGENCE OR OTHER TORTIOUS ACTION, ARISING OUT OF OR IN
   CONNECTION WITH THE USE OR PERFORMANCE OF THIS SOFTWARE.

   VST is a registered trademark of Steinberg Media Technologies GmbH. */
#ifndef VST3_H
#define VST3_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef int32_t v3_result;
typedef int16_t v3_str_128[128];
typedef uint8_t v3_bool;
typedef uint32_t v3_param_id;
typedef uint8_t v3_tuid[16];

static inline bool v3_tuid_match(const v3_tuid a, const v3_tuid b) {
    return memcmp(a, b, sizeof(v3_tuid)) == 0;
}

#define V3_BYTE(word, byte) ((word) >> 8 * (byte) & 0xFF)
#if defined _WIN32
#define V3_API __stdcall
#define V3_EXPORT __declspec(dllexport)
#define V3_OK ((v3_result)0)
#define V3_FALSE ((v3_result)1)
#define V3_NO_INTERFACE ((v3_result)0x80004002)
#define V3_NOT_IMPLEMENTED ((v3_result)0x80004001)
#define V3_INVALID_ARG ((v3_result)0x80070057)
#define V3_NOT_INITIALIZED ((v3_result)0x8000FFFF)
#define V3_NOMEM ((v3_result)0x8007000E)
#define V3_ID(a, b, c, d) { \
    V3_BYTE(a, 0), V3_BYTE(a, 1), V3_BYTE(a, 2), V3_BYTE(a, 3), \
    V3_BYTE(b, 2), V3_BYTE(b, 3), V3_BYTE(b, 0), V3_BYTE(b, 1), \
    V3_BYTE(c, 3), V3_BYTE(c, 2), V3_BYTE(c, 1), V3_BYTE(c, 0), \
    V3_BYTE(d, 3), V3_BYTE(d, 2), V3_BYTE(d, 1), V3_BYTE(d, 0)}
#else
#define V3_API
#define V3_EXPORT __attribute__((visibility("default")))
#define V3_NO_INTERFACE ((v3_result)-1)
#define V3_OK ((v3_result)0)
#define V3_FALSE ((v3_result)1)
#define V3_INVALID_ARG ((v3_result)2)
#define V3_NOT_IMPLEMENTED ((v3_result)3)
#define V3_NOT_INITIALIZED ((v3_result)5)
#define V3_NOMEM ((v3_result)6)
#define V3_ID(a, b, c, d) { \
    V3_BYTE(a, 3), V3_BYTE(a, 2), V3_BYTE(a, 1), V3_BYTE(a, 0), \
    V3_BYTE(b, 3), V3_BYTE(b, 2), V3_BYTE(b, 1), V3_BYTE(b, 0), \
    V3_BYTE(c, 3), V3_BYTE(c, 2), V3_BYTE(c, 1), V3_BYTE(c, 0), \
    V3_BYTE(d, 3), V3_BYTE(d, 2), V3_BYTE(d, 1), V3_BYTE(d, 0)}
#endif

/* ---- base */

#define V3_FUNKNOWN \
    v3_result (V3_API *query_interface)(void *self, const v3_tuid iid, void **object); \
    uint32_t (V3_API *ref)(void *self); \
    uint32_t (V3_API *unref)(void *self);
struct v3_funknown {
    V3_FUNKNOWN
};
static const v3_tuid v3_funknown_iid = V3_ID(0x00000000, 0x00000000, 0xC0000000, 0x00000046);

#define V3_PLUGIN_BASE \
    V3_FUNKNOWN \
    v3_result (V3_API *initialize)(void *self, struct v3_funknown **context); \
    v3_result (V3_API *terminate)(void *self);
static const v3_tuid v3_plugin_base_iid = V3_ID(0x22888DDB, 0x156E45AE, 0x8358B348, 0x08190625);

struct v3_bstream {
    V3_FUNKNOWN
    v3_result (V3_API *read)(void *self, void *buffer, int32_t num_bytes, int32_t *bytes_read);
    v3_result (V3_API *write)(void *self, void *buffer, int32_t num_bytes, int32_t *bytes_written);
    v3_result (V3_API *seek)(void *self, int64_t pos, int32_t seek_mode, int64_t *result);
    v3_result (V3_API *tell)(void *self, int64_t *pos);
};

/* ---- factory */

struct v3_factory_info {
    char vendor[64];
    char url[256];
    char email[128];
    int32_t flags;
};
struct v3_class_info {
    v3_tuid class_id;
    int32_t cardinality;
    char category[32];
    char name[64];
};
struct v3_class_info_2 {
    v3_tuid class_id;
    int32_t cardinality;
    char category[32];
    char name[64];
    uint32_t class_flags;
    char sub_categories[128];
    char vendor[64];
    char version[64];
    char sdk_version[64];
};
struct v3_class_info_3 {
    v3_tuid class_id;
    int32_t cardinality;
    char category[32];
    int16_t name[64];
    uint32_t class_flags;
    char sub_categories[128];
    int16_t vendor[64];
    int16_t version[64];
    int16_t sdk_version[64];
};
struct v3_plugin_factory_3 {
    V3_FUNKNOWN
    v3_result (V3_API *get_factory_info)(void *self, struct v3_factory_info *info);
    int32_t (V3_API *num_classes)(void *self);
    v3_result (V3_API *get_class_info)(void *self, int32_t idx, struct v3_class_info *info);
    v3_result (V3_API *create_instance)(
        void *self, const v3_tuid class_id, const v3_tuid iid, void **instance);
    v3_result (V3_API *get_class_info_2)(void *self, int32_t idx, struct v3_class_info_2 *info);
    v3_result (V3_API *get_class_info_utf16)(void *self, int32_t idx, struct v3_class_info_3 *info);
    v3_result (V3_API *set_host_context)(void *self, struct v3_funknown **host);
};
static const v3_tuid v3_plugin_factory_iid = V3_ID(0x7A4D811C, 0x52114A1F, 0xAED9D2EE, 0x0B43BF9F);
static const v3_tuid v3_plugin_factory_2_iid = V3_ID(0x0007B650, 0xF24B4C0B, 0xA464EDB9, 0xF00B2ABB);
static const v3_tuid v3_plugin_factory_3_iid = V3_ID(0x4555A2AB, 0xC1234E57, 0x9B122910, 0x36878931);

/* ---- component */

enum { V3_AUDIO, V3_EVENT };
enum { V3_INPUT, V3_OUTPUT };
enum { V3_MAIN, V3_AUX };
enum { V3_DEFAULT_ACTIVE = 1 };
struct v3_bus_info {
    int32_t media_type;
    int32_t direction;
    int32_t channel_count;
    v3_str_128 bus_name;
    int32_t bus_type;
    uint32_t flags;
};
struct v3_routing_info {
    int32_t media_type;
    int32_t bus_idx;
    int32_t channel;
};
struct v3_component {
    V3_PLUGIN_BASE
    v3_result (V3_API *get_controller_class_id)(void *self, v3_tuid class_id);
    v3_result (V3_API *set_io_mode)(void *self, int32_t io_mode);
    int32_t (V3_API *get_bus_count)(void *self, int32_t media_type, int32_t bus_direction);
    v3_result (V3_API *get_bus_info)(void *self, int32_t media_type, int32_t bus_direction,
                                     int32_t bus_idx, struct v3_bus_info *bus_info);
    v3_result (V3_API *get_routing_info)(
        void *self, struct v3_routing_info *input, struct v3_routing_info *output);
    v3_result (V3_API *activate_bus)(
        void *self, int32_t media_type, int32_t bus_direction, int32_t bus_idx, v3_bool state);
    v3_result (V3_API *set_active)(void *self, v3_bool state);
    v3_result (V3_API *set_state)(void *self, struct v3_bstream **stream);
    v3_result (V3_API *get_state)(void *self, struct v3_bstream **stream);
};
static const v3_tuid v3_component_iid = V3_ID(0xE831FF31, 0xF2D54301, 0x928EBBEE, 0x25697802);

/* ---- events */

struct v3_event_note_on {
    int16_t channel;
    int16_t pitch;
    float tuning;
    float velocity;
    int32_t length;
    int32_t note_id;
};
struct v3_event_note_off {
    int16_t channel;
    int16_t pitch;
    float velocity;
    int32_t note_id;
    float tuning;
};
struct v3_event_data {
    uint32_t size;
    uint32_t type;
    const uint8_t *bytes;
};
struct v3_event_chord {
    int16_t root;
    int16_t bass_note;
    int16_t mask;
    uint16_t text_len;
    const int16_t *text;
};
enum { V3_EVENT_NOTE_ON, V3_EVENT_NOTE_OFF };
struct v3_event {
    int32_t bus_index;
    int32_t sample_offset;
    double ppq_position;
    uint16_t flags;
    uint16_t type;
    union {
        struct v3_event_note_on note_on;
        struct v3_event_note_off note_off;
        struct v3_event_data data;
        struct v3_event_chord chord;
    };
};
struct v3_event_list {
    V3_FUNKNOWN
    uint32_t (V3_API *get_event_count)(void *self);
    v3_result (V3_API *get_event)(void *self, int32_t idx, struct v3_event *event);
    v3_result (V3_API *add_event)(void *self, struct v3_event *event);
};

/* ---- audio processor */

typedef uint64_t v3_speaker_arrangement;
#define V3_SPEAKER_L ((v3_speaker_arrangement)1 << 0)
#define V3_SPEAKER_R ((v3_speaker_arrangement)1 << 1)
#define V3_SPEAKER_M ((v3_speaker_arrangement)1 << 19)
enum { V3_SAMPLE_32, V3_SAMPLE_64 };
#define V3_NO_TAIL_END UINT32_MAX

struct v3_process_setup {
    int32_t process_mode;
    int32_t symbolic_sample_size;
    int32_t max_block_size;
    double sample_rate;
};
struct v3_param_value_queue {
    V3_FUNKNOWN
    v3_param_id (V3_API *get_param_id)(void *self);
    int32_t (V3_API *get_point_count)(void *self);
    v3_result (V3_API *get_point)(void *self, int32_t idx, int32_t *sample_offset, double *value);
    v3_result (V3_API *add_point)(void *self, int32_t sample_offset, double value, int32_t *idx);
};
struct v3_param_changes {
    V3_FUNKNOWN
    int32_t (V3_API *get_param_count)(void *self);
    struct v3_param_value_queue **(V3_API *get_param_data)(void *self, int32_t idx);
    struct v3_param_value_queue **(V3_API *add_param_data)(void *self, const v3_param_id *id, int32_t *idx);
};
struct v3_audio_bus_buffers {
    int32_t num_channels;
    uint64_t channel_silence_bitset;
    union {
        float **channel_buffers_32;
        double **channel_buffers_64;
    };
};
struct v3_process_context { /* its beginning */
    uint32_t state;
    double sample_rate;
    int64_t project_time_in_samples;
};
enum { V3_PLAYING = 1 << 1, V3_NEEDS_TRANSPORT_STATE = 1 << 10 };
struct v3_process_data {
    int32_t process_mode;
    int32_t symbolic_sample_size;
    int32_t nframes;
    int32_t num_input_buses;
    int32_t num_output_buses;
    struct v3_audio_bus_buffers *inputs;
    struct v3_audio_bus_buffers *outputs;
    struct v3_param_changes **input_params;
    struct v3_param_changes **output_params;
    struct v3_event_list **input_events;
    struct v3_event_list **output_events;
    struct v3_process_context *ctx;
};
struct v3_audio_processor {
    V3_FUNKNOWN
    v3_result (V3_API *set_bus_arrangements)(void *self, v3_speaker_arrangement *inputs,
        int32_t num_inputs, v3_speaker_arrangement *outputs, int32_t num_outputs);
    v3_result (V3_API *get_bus_arrangement)(
        void *self, int32_t bus_direction, int32_t idx, v3_speaker_arrangement *arrangement);
    v3_result (V3_API *can_process_sample_size)(void *self, int32_t symbolic_sample_size);
    uint32_t (V3_API *get_latency_samples)(void *self);
    v3_result (V3_API *setup_processing)(void *self, struct v3_process_setup *setup);
    v3_result (V3_API *set_processing)(void *self, v3_bool state);
    v3_result (V3_API *process)(void *self, struct v3_process_data *data);
    uint32_t (V3_API *get_tail_samples)(void *self);
};
static const v3_tuid v3_audio_processor_iid = V3_ID(0x42043F99, 0xB7DA453C, 0xA569E79D, 0x9AAEC33D);

struct v3_process_context_requirements {
    V3_FUNKNOWN
    uint32_t (V3_API *get_process_context_requirements)(void *self);
};
static const v3_tuid v3_process_context_requirements_iid =
    V3_ID(0x2A654303, 0xEF764E3D, 0x95B5FE83, 0x730EF6D0);

/* ---- edit controller */

enum { V3_PARAM_CAN_AUTOMATE = 1 << 0, V3_PARAM_IS_LIST = 1 << 3, V3_PARAM_IS_HIDDEN = 1 << 4 };
struct v3_param_info {
    v3_param_id param_id;
    v3_str_128 title;
    v3_str_128 short_title;
    v3_str_128 units;
    int32_t step_count;
    double default_normalised_value;
    int32_t unit_id;
    int32_t flags;
};
struct v3_component_handler;
struct v3_plugin_view;
struct v3_edit_controller {
    V3_PLUGIN_BASE
    v3_result (V3_API *set_component_state)(void *self, struct v3_bstream **stream);
    v3_result (V3_API *set_state)(void *self, struct v3_bstream **stream);
    v3_result (V3_API *get_state)(void *self, struct v3_bstream **stream);
    int32_t (V3_API *get_parameter_count)(void *self);
    v3_result (V3_API *get_parameter_info)(void *self, int32_t param_idx, struct v3_param_info *info);
    v3_result (V3_API *get_parameter_string_for_value)(
        void *self, v3_param_id id, double normalised, v3_str_128 output);
    v3_result (V3_API *get_parameter_value_for_string)(
        void *self, v3_param_id id, int16_t *input, double *output);
    double (V3_API *normalised_parameter_to_plain)(void *self, v3_param_id id, double normalised);
    double (V3_API *plain_parameter_to_normalised)(void *self, v3_param_id id, double plain);
    double (V3_API *get_parameter_normalised)(void *self, v3_param_id id);
    v3_result (V3_API *set_parameter_normalised)(void *self, v3_param_id id, double normalised);
    v3_result (V3_API *set_component_handler)(void *self, struct v3_component_handler **handler);
    struct v3_plugin_view **(V3_API *create_view)(void *self, const char *name);
};
static const v3_tuid v3_edit_controller_iid = V3_ID(0xDCD7BBE3, 0x7742448D, 0xA874AACC, 0x979C759E);

struct v3_midi_mapping {
    V3_FUNKNOWN
    v3_result (V3_API *get_midi_controller_assignment)(
        void *self, int32_t bus, int16_t channel, int16_t cc, v3_param_id *id);
};
static const v3_tuid v3_midi_mapping_iid = V3_ID(0xDF0FF9F7, 0x49B74669, 0xB63AB732, 0x7ADBF5E5);

#endif
