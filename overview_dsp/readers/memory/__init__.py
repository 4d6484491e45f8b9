"""Data that is no file on this machine: frames, arrays, lists, open files, bytes, addresses."""
