"""Analysis of samples, without files: heartbeats, extrema, gaps, loudness, cheers, splits."""
