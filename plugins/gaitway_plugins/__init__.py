"""Devices that come with gaitway."""
