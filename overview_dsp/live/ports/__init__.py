"""Ports that bytes and messages come through: serial, Bluetooth, MIDI, OSC, pads, phones."""
