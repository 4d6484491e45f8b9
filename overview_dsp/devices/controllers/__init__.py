"""Controllers: OSC messages and MIDI bytes to control events and parameters; opens no port."""
