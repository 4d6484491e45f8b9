"""Live session: player, window and presets, loop, live updates, commands, status."""
