"""Tables as files have them: one module a format, each with `sniff` and `open_table`."""
