"""Offline rendering of single gestures and batches, and its outputs."""
