"""Clocks, links and suites for testing plugins without hardware."""
