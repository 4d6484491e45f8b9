"""What moves the hand of a session: lines, sensors, controllers, motors, feeds."""
