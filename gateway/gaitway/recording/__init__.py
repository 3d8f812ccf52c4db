"""MCAP recordings: writing, reading, keeping within bounds."""
