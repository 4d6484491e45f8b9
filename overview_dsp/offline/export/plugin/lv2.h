/* LV2 1.18 (https://lv2plug.in): the declarations of its core, atom, midi and urid headers that an
   instrument needs, without their comments and C++.

   Copyright 2006-2020 Steve Harris, David Robillard.
   Based on LADSPA, Copyright 2000-2002 Richard W.E. Furse, Paul Barton-Davis, Stefan Westerfeld.

   Permission to use, copy, modify, and/or distribute this software for any
   purpose with or without fee is hereby granted, provided that the above
   copyright notice and this permission notice appear in all copies.

   THE SOFTWARE IS PROVIDED "AS IS" AND THE AUTHOR DISCLAIMS ALL WARRANTIES
   WITH REGARD TO THIS SOFTWARE INCLUDING ALL IMPLIED WARRANTIES OF
   MERCHANTABILITY AND FITNESS. IN NO EVENT SHALL THE AUTHOR BE LIABLE FOR
   ANY SPECIAL, DIRECT, INDIRECT, OR CONSEQUENTIAL DAMAGES OR ANY DAMAGES
   WHATSOEVER RESULTING FROM LOSS OF USE, DATA OR PROFITS, WHETHER IN AN
   ACTION OF CONTRACT, NEGLIGENCE OR OTHER TORTIOUS ACTION, ARISING OUT OF
   OR IN CONNECTION WITH THE USE OR PERFORMANCE OF THIS SOFTWARE. */
#ifndef LV2_H
#define LV2_H
#include <stdint.h>

#ifdef _WIN32
#define LV2_SYMBOL_EXPORT __declspec(dllexport)
#else
#define LV2_SYMBOL_EXPORT __attribute__((visibility("default")))
#endif

#define LV2_ATOM__Sequence "http://lv2plug.in/ns/ext/atom#Sequence"
#define LV2_ATOM__Object "http://lv2plug.in/ns/ext/atom#Object"
#define LV2_MIDI__MidiEvent "http://lv2plug.in/ns/ext/midi#MidiEvent"
#define LV2_URID__map "http://lv2plug.in/ns/ext/urid#map"

#define LV2_TIME__Position "http://lv2plug.in/ns/ext/time#Position"
#define LV2_TIME__frame "http://lv2plug.in/ns/ext/time#frame"
#define LV2_TIME__speed "http://lv2plug.in/ns/ext/time#speed"

typedef void *LV2_Handle;
typedef struct {
  const char *URI;
  void *data;
} LV2_Feature;
typedef struct LV2_Descriptor {
  const char *URI;
  LV2_Handle (*instantiate)(const struct LV2_Descriptor *descriptor,
                            double sample_rate,
                            const char *bundle_path,
                            const LV2_Feature *const *features);
  void (*connect_port)(LV2_Handle instance, uint32_t port, void *data_location);
  void (*activate)(LV2_Handle instance);
  void (*run)(LV2_Handle instance, uint32_t sample_count);
  void (*deactivate)(LV2_Handle instance);
  void (*cleanup)(LV2_Handle instance);
  const void *(*extension_data)(const char *uri);
} LV2_Descriptor;
LV2_SYMBOL_EXPORT const LV2_Descriptor *lv2_descriptor(uint32_t index);

typedef uint32_t LV2_URID;
typedef struct {
  void *handle;
  LV2_URID (*map)(void *handle, const char *uri);
} LV2_URID_Map;

typedef struct {
  uint32_t size;
  uint32_t type;
} LV2_Atom;
typedef struct {
  uint32_t id;
  uint32_t otype;
} LV2_Atom_Object_Body;
typedef struct {
  LV2_URID key;
  uint32_t context;
  LV2_Atom value;
} LV2_Atom_Property_Body;
typedef struct {
  union {
    int64_t frames;
    double beats;
  } time;
  LV2_Atom body;
} LV2_Atom_Event;
typedef struct {
  uint32_t unit;
  uint32_t pad;
} LV2_Atom_Sequence_Body;
typedef struct {
  LV2_Atom atom;
  LV2_Atom_Sequence_Body body;
} LV2_Atom_Sequence;

#endif
