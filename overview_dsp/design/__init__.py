"""How it feels and how it is moved: presets and gestures."""
