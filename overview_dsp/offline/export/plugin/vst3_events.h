/* What a block brings in VST3: points of parameters and notes, heard in the order of their frames. */
#ifndef OVERVIEW_VST3_EVENTS_H
#define OVERVIEW_VST3_EVENTS_H
#include "vst3_controller.h"

enum { MOST_QUEUES = 2 * PARAMETERS };

/* A parameter's points, with the next one read; which < 0: there is none. */
typedef struct {
    struct v3_param_value_queue **queue;
    int which;
    int32_t next, count, at;
    double value;
} points;

static void points_read(points *p) {
    while (p->next < p->count)
        if ((*p->queue)->get_point(p->queue, p->next++, &p->at, &p->value) == V3_OK) return;
    p->which = -1;
}
/* At one frame, an image comes before values for it. */
static int points_before(const points *a, const points *b) {
    return a->at < b->at || (a->at == b->at && voice_chooses(a->which) && !voice_chooses(b->which));
}

static void tell(const instance *self, struct v3_param_changes **out, int which, int32_t at) {
    const v3_param_id id = parameter_number(which);
    int32_t index = 0;
    struct v3_param_value_queue **queue = out ? (*out)->add_param_data(out, &id, &index) : NULL;
    if (queue)
        (*queue)->add_point(queue, at, value_normal(&self->voice, which, self->voice.applied[which]), &index);
}

static void hear_point(
    instance *self, int which, double normal, int32_t at, struct v3_param_changes **out) {
    voice *v = &self->voice;
    double before = v->applied[VOICE_PRESET];
    if (which == PARAMETER_RELEASE) voice_release(v, -1, at);
    else if (which == PARAMETER_WHEEL) {
        int wheel = normal >= 0.0 && normal <= 1.0 ? (int)(normal * 127.0 + 0.5) : self->wheel;
        uint8_t message[3] = {0xB0, 1, (uint8_t)wheel};
        /* a host may say at any time where it is */
        if (wheel != self->wheel && voice_midi(v, message, at)) tell(self, out, VOICE_THETA2, at);
        self->wheel = wheel;
    } else {
        voice_set(v, which, value_plain(v, which, normal, v->applied), at);
        if (v->applied[VOICE_PRESET] != before)
            for (which = VOICE_OWN; which < VOICE_VALUES; which++) tell(self, out, which, at);
    }
}
static void hear_note(voice *v, const struct v3_event *event, int32_t at) {
    int key = event->type == V3_EVENT_NOTE_ON ? event->note_on.pitch : event->note_off.pitch;
    if (key < 0 || key > 127) return;
    if (event->type == V3_EVENT_NOTE_ON && event->note_on.velocity > 0.0f) voice_press(v, key, at);
    else if (event->type <= V3_EVENT_NOTE_OFF) voice_release(v, key, at);
}

static int32_t later(int32_t at, int32_t offset, int32_t frames) {
    return offset <= at ? at : offset < frames ? offset : frames;
}

static void hear(instance *self, const struct v3_process_data *data) {
    struct v3_param_changes **changes = data->input_params;
    struct v3_event_list **notes = data->input_events;
    int32_t i, n = changes ? (*changes)->get_param_count(changes) : 0, count = 0, at = 0;
    int32_t note = 0, notes_count = notes ? (int32_t)(*notes)->get_event_count(notes) : 0;
    points queues[MOST_QUEUES];
    for (i = 0; i < n && count < MOST_QUEUES; i++) {
        points *p = &queues[count];
        if (!(p->queue = (*changes)->get_param_data(changes, i))) continue;
        p->which = parameter_of((*p->queue)->get_param_id(p->queue));
        p->next = 0, p->count = (*p->queue)->get_point_count(p->queue);
        if (p->which >= 0) points_read(p), count++;
    }
    for (;;) {
        struct v3_event event;
        points *first = NULL;
        int read = 0;
        for (i = 0; i < count; i++)
            if (queues[i].which >= 0 && (!first || points_before(&queues[i], first))) first = &queues[i];
        while (note < notes_count && !(read = (*notes)->get_event(notes, note, &event) == V3_OK)) note++;
        if (read && (!first || event.sample_offset < first->at)) {
            at = later(at, event.sample_offset, data->nframes), note++;
            hear_note(&self->voice, &event, at);
        } else if (first) {
            at = later(at, first->at, data->nframes);
            hear_point(self, first->which, first->value, at, data->output_params);
            points_read(first);
        } else return;
    }
}

#endif
