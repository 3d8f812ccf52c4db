"""Walks from files: reading them strictly, and feeding them to an estimator."""
