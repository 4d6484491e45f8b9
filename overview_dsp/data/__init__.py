"""Timelines, and the readers, feeds and analysis that produce them."""
