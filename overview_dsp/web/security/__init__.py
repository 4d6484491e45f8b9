"""The server's door: who may ask, from where, how much."""
