"""Recording of takes during a session, and recovery of interrupted ones."""
