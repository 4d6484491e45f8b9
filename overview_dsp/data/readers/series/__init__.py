"""Timelines of series: a table of times and values becomes a curve, gaps and events."""
