"""Benchmarks of the engine on this machine, compared with alternatives."""
