"""Signal path: friction surface, engine, and actuator drive."""
