"""Timelines that are still growing."""
