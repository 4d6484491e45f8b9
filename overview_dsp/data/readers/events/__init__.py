"""Readers of event lists: tables, calendars, subtitles, label tracks."""
