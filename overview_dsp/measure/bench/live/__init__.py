"""How the live output holds on this machine: callback times, frames lost, control latency."""
