"""Controllers: OSC messages and MIDI bytes in, control events and parameters out; opens no port."""
