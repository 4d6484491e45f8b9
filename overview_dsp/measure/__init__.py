"""What a finger or an ear gets: felt levels by stroke and event, onsets in the clicks."""
