"""Connections to devices: serial, Bluetooth, MIDI, OSC, game pads, phones."""
