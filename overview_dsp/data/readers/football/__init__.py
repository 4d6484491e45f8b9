"""Football matches from other people's files: one reader a format, one way to score and label."""
