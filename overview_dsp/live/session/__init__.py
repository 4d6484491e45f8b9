"""A session: the player, its view of the timeline, its loop and its commands."""
