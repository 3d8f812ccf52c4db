"""How well a fit agrees with its reference (Bland and Altman), in figures and as a picture."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitway.api import Floats

LIMITS = 1.96


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """Fitted values beside those of a reference.

    Attributes:
        fitted: Shape (n,).
        reference: Shape (n,).
        unit: Of both.
    """

    fitted: Floats
    reference: Floats
    unit: str

    @property
    def differences(self) -> Floats:
        """Return fitted less reference, shape (n,)."""
        return self.fitted - self.reference

    @property
    def rms(self) -> float:
        """Return the root mean square of the differences."""
        return float(np.sqrt(np.mean(self.differences**2)))

    @property
    def r_squared(self) -> float:
        """Return the coefficient of determination."""
        spread = float(np.sum((self.reference - self.reference.mean()) ** 2))
        return 1.0 - float(np.sum(self.differences**2)) / max(spread, 1e-12)

    @property
    def bias(self) -> float:
        """Return the mean difference."""
        return float(self.differences.mean())

    @property
    def limits(self) -> tuple[float, float]:
        """Return between what 95 % of the differences lie."""
        half = LIMITS * float(self.differences.std(ddof=1))
        return self.bias - half, self.bias + half

    def findings(self) -> list[str]:
        """Return a line for each figure."""
        low, high = self.limits
        return [
            f"R^2 {self.r_squared:.4f} over {len(self.fitted)} readings",
            f"RMS difference {self.rms:.2f} {self.unit}",
            f"greatest difference {np.abs(self.differences).max():.2f} {self.unit}",
            f"bias {self.bias:+.2f} {self.unit}",
            f"95 % limits of agreement {low:+.2f} to {high:+.2f} {self.unit}",
        ]

    def draw(self, axes: Any) -> None:
        """Draw the differences over the means on a matplotlib ``Axes``."""
        axes.plot(0.5 * (self.fitted + self.reference), self.differences, ".", markersize=4)
        for level, style in ((self.bias, "-"), *((limit, "--") for limit in self.limits)):
            axes.axhline(level, color="k", linestyle=style, linewidth=1.0)
        axes.set_xlabel(f"mean of fit and reference, {self.unit}")
        axes.set_ylabel(f"fit - reference, {self.unit}")
        axes.set_title("Bland-Altman: bias and 95 % limits")
