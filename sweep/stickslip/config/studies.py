"""Studies: what a configuration may ask for instead of a map of every cell, and the table of them.

A study is declared in one file of the room `studies`, as a class that `STUDIES` names: the section that asks for it,
the variables of its result, how it is computed, and how its result is told and drawn. Files are imported when a
configuration or a result has to do with them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import islice
from math import prod
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from stickslip import extensions
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import python_document
from stickslip.config.sections import AnySection, StudySection, plain
from stickslip.config.yaml import Setting, overridden
from stickslip.errors import ArgumentError, Path, Problem, dotted
from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.quantities import BESIDE, QUANTITIES, STUDIES, kind_of

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.rules import Finding, QuantitySpace
    from stickslip.engine import Options, Results, StopFlag
    from stickslip.vocabulary.cells import Cells

MOST_ROWS = 30  # of a table on the screen
_SETTINGS = ("tolerance", "rtol", "scan", "points")
KEYS = (
    *(field for field in Config.model_fields if field not in ("study", "beside", "uncertain")),
    *STUDIES,
    *BESIDE,
)  # of a file

Moved = Callable[[int], None]


def is_config(given: object) -> bool:
    """True for a configuration in any of its forms, and not for a mapping of parameters of cells."""
    return isinstance(given, Config | str | PathLike) or (
        isinstance(given, Mapping) and any(key in KEYS for key in given)
    )


@cache
def study_class(key: str) -> type[Study]:
    """The study of a key of `STUDIES`."""
    study: type[Study] = extensions.imported(STUDIES[key].place)
    return study


def result_class(ds: xr.Dataset) -> type[Result] | None:
    """What says how a result is shown: the study that it is of, or the kind that an extension brings; None for maps,
    lists of cells and trajectories."""
    kind = kind_of(ds)
    if kind in STUDIES:
        return study_class(kind)
    places = extensions.brought("results")
    return extensions.imported(places[kind]) if kind in places else None


def section_class(key: str) -> type[StudySection]:
    """The section of a key of `STUDIES`."""
    return study_class(key).section


def section_of_call(model: type[AnySection], **values: Any) -> AnySection:
    """A section from the arguments of a call, of which None is not given. Raises ArgumentError."""
    document = python_document({"call": {name: value for name, value in values.items() if value is not None}})
    problems = ProblemCollector(document, in_full=True)
    section = None if document.problems else problems.read(model, ("call",), document.data["call"])
    for problem in problems.problems:
        hint = f"; {problem.hint}" if problem.hint else ""
        raise ArgumentError(dotted(problem.path[1:]), f"{problem.message}{hint}")
    assert section is not None
    return section


def section_with(
    model: type[StudySection], own: StudySection | None, settings: Iterable[Setting], name: str
) -> StudySection:
    """The section of a study with settings of a command line; `name` stands for a file. Raises ConfigError."""
    key = model.key
    document = overridden(python_document({key: own.resolved() if own else {}}, name), settings)
    problems = ProblemCollector(document)
    section = problems.read(model, (key,), document.data[key])
    problems.raise_any()
    assert section is not None
    return section


class Regime(str):
    """The name of a regime in a table, where pages show its colour."""


class ReportTable(NamedTuple):
    """A table for people. words, numbers : headings of columns, those of numbers last. rows : of both."""

    title: str
    words: Sequence[str]
    numbers: Sequence[str]
    rows: Iterable[Sequence[str]]

    def text(self) -> str:
        """The table in lines, words at the left and numbers at the right."""
        columns = [*zip((*self.words, *self.numbers), *self.rows, strict=True)]
        widths = [max(map(len, column)) for column in columns]
        padded = [
            [cell.ljust(width) if i < len(self.words) else cell.rjust(width) for cell in column]
            for i, (column, width) in enumerate(zip(columns, widths, strict=True))
        ]
        return "\n".join("  ".join(row).rstrip() for row in zip(*padded, strict=True))


class Result(ABC):
    """What a kind of result says of itself: on screen, in pictures and tables, on its page.

    variables : of it, by name. subject : the variable that it is about.
    places : what the dimensions of the subject are of, "cells" or "lines".
    caption : of the only picture of a page, if it is the only one. over_map : whether it is drawn over a map of cells.
    """

    variables: ClassVar[Mapping[str, Variable]]
    subject: ClassVar[str] = "regime"
    places: ClassVar[str] = "cells"
    caption: ClassVar[str] = ""
    over_map: ClassVar[bool] = False

    @classmethod
    def own_dims(cls) -> set[str]:
        """The dimensions of its variables beyond those of the cells."""
        return {dim for row in cls.variables.values() for dim in row.dims}

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[Any]:
        """The result for the screen: lines, each a `Table`, or whatever Rich prints."""
        yield from ()

    @classmethod
    def answer(cls, ds: xr.Dataset) -> Mapping[str, Any]:
        """What `--json` tells of the result beside its regimes."""
        return {}

    @classmethod
    def table(cls, ds: xr.Dataset) -> ReportTable | None:
        """The table of its page, if it has one."""
        return None

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """True if there is a plot of this result."""
        return cls.subject in ds and ds[cls.subject].ndim > 0

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """The plot of a variable, or of what the result is about; None where that is a map, or over one.

        Arguments as of `plots.plot_result`, whose errors it raises.
        """
        return None

    @classmethod
    def mapped(cls, ds: xr.Dataset) -> Sequence[str]:
        """The variables whose maps are on its page, beside those that every map has."""
        return ()

    @classmethod
    def page(cls, ds: xr.Dataset, title: str | None) -> str | None:
        """The whole page, of a result that has one of its own."""
        return None

    @classmethod
    def tabular(cls, ds: xr.Dataset, whole: bool) -> xr.Dataset:
        """The result as a table holds it; unless `whole`, with those variables alone that are its columns."""
        return ds


class Study(Result):
    """Items in a row, any range of which can be computed by itself, anywhere, any number of times, to the same bits.

    about, examples : of the command: sentences below its first, and words behind its name.
    own_conditions : whether cells are those of its section, where quantities may be given that vary elsewhere, and
        where what cannot be is no error. with_indices : whether Sobol indices of what is uncertain are of use.
    section : that asks for it. title : of the result of a Python call.
    name : of the result, for people ("map"). counted : what its items are ("cells", "lines").
    dims, shape : of the items, the last index running fastest. options : of the integration.
    cells_each : about how many cells an item takes. weight : blocks have so many times fewer items than those of a map.
    ragged : whether columns may have other lengths than the range has items.
    is_array : whether its columns, of all items, are the variables of the result; then blocks are chunks of its file.
    columns : names and types of the results of a range: int8, int32 or float64, flat.
    """

    section: ClassVar[type[StudySection]]
    about: ClassVar[str] = ""
    examples: ClassVar[Sequence[str]] = ()
    own_conditions: ClassVar[bool] = False
    with_indices: ClassVar[bool] = True
    title: str
    name: str
    counted: str
    cells_each: int = 1
    weight: int = 1
    ragged: bool = False
    is_array: bool = False
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    options: Options
    columns: Mapping[str, np.dtype[Any]]

    # --- what is asked ------------------------------------------------------------------------------------------------

    @classmethod
    def of(cls, given: Any, section: Any, options: Options) -> Study:
        """The study of a configuration, or of cells as `evaluate` takes them, that a section asks for.

        Raises TypeError or ValueError for what cannot be.
        """
        raise NotImplementedError

    @classmethod
    def check(cls, section: Any, config: Config, problems: ProblemCollector) -> None:
        """Note what is wrong between the section and the rest of the configuration."""
        return None

    @classmethod
    def misplaced(cls, data: Mapping[str, Any]) -> Iterator[Problem]:
        """What does not belong into the plain data of a file with this study, or is missing."""
        yield from ()

    @classmethod
    def rules(cls, section: Any, space: QuantitySpace, given: Mapping[str, Sequence[Path]]) -> Iterator[Finding]:
        """The rules between quantities that the study has beside those of cells. given : where, by name."""
        yield from ()

    @classmethod
    def given_in(cls, raw: Any) -> Iterator[Path]:
        """The places, in the plain data of the section, of quantities that it gives itself."""
        yield from ()

    @classmethod
    def conditions(cls, section: Any) -> Mapping[str, float]:
        """Quantities that the section gives itself, in SI."""
        return {}

    @classmethod
    def lines_in(cls, section: Any, config: Config) -> Mapping[str, Any]:
        """By parameter, the lines of a study whose result is drawn over a map of its cells; none of others."""
        return {}

    @classmethod
    def explain(cls, section: Any, config: Config) -> Iterator[tuple[str, str, str]]:
        """The section as it was understood: rows of name, value and meaning; by default those of its fields."""
        for name, field in type(section).model_fields.items():
            value, quantity = getattr(section, name), name if name in QUANTITIES else getattr(section, "along", "")
            if value is not None and value != {}:
                is_range = isinstance(value, tuple) and quantity in QUANTITIES and isinstance(value[0], float)
                text = QUANTITIES[quantity].range_text(value) if is_range else str(plain(value))
                yield f"{section.key} {name}", text, str(field.description)

    def described(self) -> str:
        """`57,600 cells: stiffness (240) x belt_speed (240)`."""
        size = prod(self.shape)
        axes = " x ".join(f"{dim} ({length})" for dim, length in zip(self.dims, self.shape, strict=True))
        return f"{size:,} {self.counted if size != 1 else self.counted.removesuffix('s')}" + (
            f": {axes}" if axes else ""
        )

    # --- how it is computed -------------------------------------------------------------------------------------------

    def sample(self, count: int) -> Cells | None:
        """About so many cells like those that are computed, to time them; None where those of the grid are alike."""
        return None

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the kernels that are known to be needed, to be compiled before the first item is computed."""
        return (self.options.law,)

    @abstractmethod
    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The results of a range of items, by the calling thread alone.

        Raises StoppedError within milliseconds once `stop` is raised. moved : called with cells computed, now and then.
        """

    def blank(self, items: range) -> Results:
        """Return what stands for a range of items that is not computed: NaN, and 0 for codes and counts."""
        return {name: np.full(len(items), np.nan if kind.kind == "f" else 0, kind)
                for name, kind in self.columns.items()}  # fmt: skip

    @abstractmethod
    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The labelled result from ranges of items, in order and without gaps.

        parts : each is read when it is asked for, so that going through them once holds one at a time.
        """


# --- reports


def shown(table: ReportTable) -> Iterator[ReportTable | str]:
    """The first rows of a table, and that there are more."""
    rows = iter(table.rows)
    yield table._replace(rows=list(islice(rows, MOST_ROWS)))
    if next(rows, None) is not None:
        yield "... and more"


def search_attributes(section: StudySection, options: Options) -> dict[str, Any]:
    """How exactly borders were looked for, as attributes of a result (``border_tolerance``)."""
    settings = section.resolved() | {"rtol": options.rtol}
    prefix = section.key.removesuffix("s")
    return {f"{prefix}_{name}": settings[name] for name in _SETTINGS if name in settings}


def search_settings(ds: xr.Dataset, prefix: str) -> str:
    """The same as a line for the screen."""
    settings = {name: ds.attrs[f"{prefix}_{name}"] for name in _SETTINGS if f"{prefix}_{name}" in ds.attrs}
    return "search   " + ", ".join(f"{name} {value:g}" for name, value in settings.items())
