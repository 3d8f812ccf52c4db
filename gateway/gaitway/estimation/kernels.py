"""The arithmetic of the filter: compiled where it could be, else its slow twin in numpy."""

try:
    from gaitway.estimation._kernels import correct, innovation, predict, run

    COMPILED = True
except ImportError:
    from gaitway.estimation._kernels_twin import correct, innovation, predict, run

    COMPILED = False

__all__ = ["COMPILED", "correct", "innovation", "predict", "run"]
