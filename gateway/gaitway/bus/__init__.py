"""Publishing on zenoh."""
