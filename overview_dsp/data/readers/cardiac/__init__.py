"""Heart recordings as timelines: every beat, the heart rate, what is out of rhythm."""
