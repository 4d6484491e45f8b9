"""Live timelines: the feed format, its sources, and the thread that follows them."""
