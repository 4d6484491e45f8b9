"""How fast the engine runs on this machine, beside other ways to do the same work."""
