"""Sensors: bytes in, the hand's control events out; opens no device."""
