"""Links and wire formats that come with gaitway."""
