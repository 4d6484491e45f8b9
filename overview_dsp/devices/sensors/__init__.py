"""Sensors: received bytes to control events; opens no device."""
