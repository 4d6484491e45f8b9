"""Readers of recordings: loudness, and cheers above the background of a crowd."""
