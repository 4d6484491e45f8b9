"""Live: the only place that opens devices."""
