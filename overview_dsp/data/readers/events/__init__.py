"""Lists of events of any kind: tables, calendars, subtitles, labels."""
