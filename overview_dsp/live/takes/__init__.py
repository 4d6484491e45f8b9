"""Recordings of a session, written as it runs, and their recovery."""
