"""Readers of heart recordings: beats, heart rate, and irregular beats."""
