"""What happened, and when: timelines, and what makes them from files, feeds and samples."""
