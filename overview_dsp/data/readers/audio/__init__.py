"""Recordings as timelines: how loud they are, and where a crowd rises above its murmur."""
