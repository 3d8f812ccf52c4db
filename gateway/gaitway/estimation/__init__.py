"""Device-independent mathematics of gait: a toolkit for whoever writes an estimator."""

from gaitway.estimation.ledger import WalkLedger

__all__ = ["WalkLedger"]
