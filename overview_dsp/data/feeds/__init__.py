"""Timelines that are still growing: what came so far, feeds, and the sources they come from."""
