"""The processor: a surface is prepared, the engine plays it, an actuator shapes its output."""
