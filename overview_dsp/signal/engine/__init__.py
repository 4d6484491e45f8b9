"""Engine: block processor, its meters and strikes, saved state and replay."""
