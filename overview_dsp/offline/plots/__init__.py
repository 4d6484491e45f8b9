"""Plots of timelines, sweeps and taps."""
