"""Access control of the server: token, origin, size and speed of requests."""
