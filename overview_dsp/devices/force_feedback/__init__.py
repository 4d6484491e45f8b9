"""Force feedback: a motor brakes the knob as the surface's friction brakes the disk."""
