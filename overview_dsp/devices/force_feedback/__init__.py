"""Force out: a motor under the knob brakes the hand as the surface's friction does."""
