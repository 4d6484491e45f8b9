"""Bytes and messages of sensors, controllers and motors, without any port."""
