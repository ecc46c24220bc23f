"""Lists of types with the facts about each: select, sort, and read as rows or a frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

from gspcli.catalogue.bounds import BOUND_NAMES, Bound, type_bounds
from gspcli.catalogue.counts import best_real, generic_counts, real_counts, spelled
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.types import GspType, PlatformClass, all_types
from gspcli.errors import GspError
from gspcli.records import dataclass
from gspcli.wording import shown

if TYPE_CHECKING:
    import pandas as pd

Value = int | str | None


@dataclass(frozen=True)
class TypeColumn:
    """A fact about every type."""

    #: The name of the column in every format.
    key: str
    #: Takes the value from a type.
    read: Callable[[GspType], Value]
    #: Whether the values are numbers, so that a ceiling can be set.
    numeric: bool = True
    #: Whether a listing shows the column without being asked.
    default: bool = True


def _bound(name: str) -> Callable[[GspType], Value]:
    def read(gsp_type: GspType) -> Value:
        bound: Bound | None = getattr(type_bounds(gsp_type), name)
        return None if bound is None else bound.value

    return read


def _count(name: str) -> Callable[[GspType], Value]:
    def read(gsp_type: GspType) -> Value:
        count: int = getattr(generic_counts(gsp_type), name)
        return count

    return read


def _names(kinds: Iterable[Kind]) -> str:
    return " ".join(kind.short for kind in kinds)


def _shared_patterns(gsp_type: GspType) -> int:
    from gspcli.catalogue.coincidence import count_coincident

    return count_coincident(gsp_type)


#: The facts about a type, in the order of the CSV.
COLUMNS: tuple[TypeColumn, ...] = (
    TypeColumn("number", lambda t: t.number),
    TypeColumn("id", lambda t: t.id, numeric=False),
    TypeColumn("class", lambda t: t.platform_class.id, numeric=False),
    TypeColumn("distances", lambda t: _names(t.distances), numeric=False),
    TypeColumn("angles", lambda t: _names(t.angles), numeric=False),
    *(TypeColumn(name, _bound(name)) for name in BOUND_NAMES),
    TypeColumn("generic_one_sided", _count("one_sided")),
    TypeColumn("generic_two_sided", _count("two_sided")),
    TypeColumn("best_real", best_real),
    TypeColumn("real_counts", lambda t: spelled(real_counts(t)), numeric=False, default=False),
    TypeColumn("patterns", _shared_patterns, default=False),
)
DEFAULT_COLUMNS: tuple[TypeColumn, ...] = tuple(c for c in COLUMNS if c.default)
COLUMNS_BY_KEY: dict[str, TypeColumn] = {column.key: column for column in COLUMNS}


def column(key: str) -> TypeColumn:
    """Return the column with a key, written with ``_`` or ``-``.

    Raises
    ------
    GspError
        If there is no such column.
    """
    found = COLUMNS_BY_KEY.get(key.strip().lower().replace("-", "_"))
    if found is None:
        raise GspError(f"unknown column {shown(key)}: the columns are {', '.join(COLUMNS_BY_KEY)}")
    return found


class TypeList(Sequence[GspType]):
    """An immutable sequence of types that can be narrowed, sorted and tabulated.

    Examples
    --------
    >>> from gspcli.catalogue.names import parse_class, parse_kind_set
    >>> planar = TypeList().where(only=parse_kind_set("PH A"))
    >>> len(planar)
    35
    >>> planar.where(classes=[parse_class("6D")])[0].id
    'DPH DPH DPH DPH DPH DPH'
    """

    def __init__(self, types: Iterable[GspType] | None = None) -> None:
        self._types = all_types() if types is None else tuple(types)

    @overload
    def __getitem__(self, index: int) -> GspType: ...
    @overload
    def __getitem__(self, index: slice) -> TypeList: ...
    def __getitem__(self, index: int | slice) -> GspType | TypeList:
        if isinstance(index, slice):
            return TypeList(self._types[index])
        return self._types[index]

    def __len__(self) -> int:
        return len(self._types)

    def __repr__(self) -> str:
        return f"<{len(self)} platform types>"

    def where(
        self,
        *,
        classes: Iterable[PlatformClass | str] = (),
        only: str | frozenset[Kind] | None = None,
        having: Iterable[str | frozenset[Kind]] = (),
        without: str | frozenset[Kind] = frozenset(),
        at_most: Mapping[str, int] | None = None,
    ) -> TypeList:
        """Return the types that satisfy every condition, in the same order.

        Parameters
        ----------
        classes
            Keep these classes, or those of these names; all when empty.
        only
            Keep types whose constraints are all of these kinds.
        having
            Keep types that have, for each of these sets, a constraint of one of its kinds.
        without
            Drop types with a constraint of one of these kinds. Kinds may be a text, as
            `parse_kind_set` reads it: "PP".
        at_most
            For each numeric column a ceiling; types without a value are dropped.

        Raises
        ------
        GspError
            If a ceiling is set for a column that is unknown or not numeric.
        """
        chosen = set(map(_class, classes))
        allowed = None if only is None else _kinds(only)
        needed, dropped = [_kinds(one) for one in having], _kinds(without)
        ceilings = []
        for key, ceiling in (at_most or {}).items():
            limited = column(key)
            if not limited.numeric:
                raise GspError(f"column {limited.key} has no numbers to compare with {ceiling}")
            ceilings.append((limited.read, ceiling))

        def keeps(gsp_type: GspType) -> bool:
            kinds = set(gsp_type.kinds)
            if chosen and gsp_type.platform_class not in chosen:
                return False
            if allowed is not None and not kinds <= allowed:
                return False
            if kinds & dropped or not all(kinds & wanted for wanted in needed):
                return False
            values = ((read(gsp_type), ceiling) for read, ceiling in ceilings)
            return all(isinstance(value, int) and value <= top for value, top in values)

        return TypeList(filter(keeps, self._types))

    def sorted_by(self, *keys: str) -> TypeList:
        """Return the types sorted by columns; ``-key`` is descending, no value comes last.

        Raises
        ------
        GspError
            If there is no such column.
        """
        types = list(self._types)
        for key in reversed(keys):
            descending = key.startswith("-")
            read = column(key.removeprefix("-")).read
            known = [t for t in types if read(t) is not None]
            unknown = [t for t in types if read(t) is None]
            known.sort(key=read, reverse=descending)  # type: ignore[arg-type]
            types = known + unknown
        return TypeList(types)

    def rows(self, columns: Sequence[TypeColumn] = DEFAULT_COLUMNS) -> Iterator[dict[str, Value]]:
        """Yield for each type a mapping from column keys to values."""
        for gsp_type in self._types:
            yield {known.key: known.read(gsp_type) for known in columns}

    def to_frame(self, columns: Sequence[TypeColumn] = DEFAULT_COLUMNS) -> pd.DataFrame:
        """Return a pandas data frame, indexed by the stable number; no value is ``<NA>``."""
        import pandas as pd

        data: dict[str, Any] = {
            known.key: pd.array(
                [known.read(gsp_type) for gsp_type in self._types],  # type: ignore[call-overload]
                dtype="Int64" if known.numeric else "string",
            )
            for known in columns
        }
        frame = pd.DataFrame(data)
        return frame.set_index("number") if "number" in data else frame


def _class(given: str | PlatformClass) -> PlatformClass:
    if not isinstance(given, str):
        return given
    from gspcli.catalogue.names import parse_class

    return parse_class(given)


def _kinds(given: str | frozenset[Kind]) -> frozenset[Kind]:
    if isinstance(given, str):
        from gspcli.catalogue.names import parse_kind_set

        return parse_kind_set(given)
    return frozenset(given)
