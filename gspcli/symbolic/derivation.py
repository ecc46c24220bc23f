"""The closed forms of Section 6, each with its table, document and text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.records import dataclass
from gspcli.symbolic.closed_forms import derive as triangular_set
from gspcli.symbolic.closed_forms import expand_case, parse_case
from gspcli.symbolic.presentation import to_document, to_latex, to_text
from gspcli.symbolic.triangular import TriangularSet

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Derivation:
    """A case of Section 6, solved.

    Attributes
    ----------
    triangular
        Its triangular set.
    expanded
        Whether its coefficients are written in the parameters alone.
    """

    triangular: TriangularSet
    expanded: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        # Expressions of SymPy change while they are written: the case is derived again.
        return _derived, (self.triangular.case, self.expanded)

    def __repr__(self) -> str:
        found = self.triangular
        degrees = "·".join(map(str, found.degrees))
        return f"<Derivation of {found.case}: degrees {degrees}, {found.solutions} solutions>"

    def __str__(self) -> str:
        return to_text(self.triangular)

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each polynomial of the set (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.to_json()["set"])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.derive/1``."""
        return to_document(self.triangular)

    def to_latex(self) -> str:
        """Return a fragment of LaTeX for amsmath."""
        return to_latex(self.triangular)


def derive(case: str, *, expand: bool = False) -> Derivation:
    """Derive the triangular set of a case of the paper's Section 6.

    Parameters
    ----------
    case
        An intersection of three surfaces (P plane, S sphere, C cylinder), as ``PSC``; ``AAA`` for
        three angles; or ``6.2`` or ``6.8`` for the example of that number.
    expand
        Whether every coefficient is written in the parameters alone.

    Raises
    ------
    GspError
        If it is none of the cases, or one that is not written out (CCC, SCC).
    """
    name = parse_case(case)
    return _derived(name, expand)


def _derived(case: str, expanded: bool) -> Derivation:
    return Derivation(expand_case(case) if expanded else triangular_set(case), expanded)
