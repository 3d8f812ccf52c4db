"""Links that move bytes."""
