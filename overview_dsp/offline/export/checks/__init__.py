"""Checks of haptic documents, all that is wrong with one: one file a format, and how files pair."""
