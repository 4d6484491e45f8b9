"""Inputs of a session: takes, text lines, sensors, controllers, motors, and live feeds."""
