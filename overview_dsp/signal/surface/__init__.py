"""Surface: friction table and event table of a timeline and a preset."""
