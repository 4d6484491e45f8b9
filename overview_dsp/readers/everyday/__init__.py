"""Event lists as people keep them: tables of any names, annotation tools' files, calendars."""
