"""Parts to simulate a person walking with a sensor: smooth motion, contact, IMU errors."""
