"""What a person should know about this installation, though it works."""

from gaitway.estimation import COMPILED

MISSING_KERNELS = (
    "note: compiled kernels are missing, estimators run about 10 x slower: "
    "install a C compiler and reinstall"
)


def print_notices() -> None:
    """Print what there is to know, a line each; nothing if all is as it should be."""
    if not COMPILED:
        print(MISSING_KERNELS)
