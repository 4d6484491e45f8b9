"""Finds things in samples, without files: heartbeats, extrema, gaps, loudness, cheers, splits."""
