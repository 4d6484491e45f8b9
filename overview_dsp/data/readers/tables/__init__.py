"""Readers of tables of times and values (CSV, JSON, Parquet), whose events are found by rules."""
