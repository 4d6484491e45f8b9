"""Studies with participants: lists, a page, answers, statistics and exports from a TOML file."""
