"""Files as they are written and read: whole or not at all; sound; TOML with its lines."""
