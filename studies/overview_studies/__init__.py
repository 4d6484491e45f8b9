"""Studies with people: from one TOML file to lists, a page, answers, statistics and exports."""
