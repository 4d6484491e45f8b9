"""Atomic writing of files, sound files, and strict TOML files."""
