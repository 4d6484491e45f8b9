"""Readers of football matches, one per file format, and the timeline that they share."""
