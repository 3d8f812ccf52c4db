"""What the operator wrote, as checked models."""
