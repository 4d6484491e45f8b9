"""Audio outputs: devices, their settings, and the streams that run an engine on them."""
