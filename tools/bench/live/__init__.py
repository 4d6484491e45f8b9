"""Benchmarks of live output: callback times, lost frames, control latency."""
