"""The pictures: timelines, sweeps and taps, presets."""
