"""What the columns of a table of points are: those that people name, those of known headings, else the materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import DECIMAL_COMMA, NUMBER, Cell, Table
from stickslip.fit.headings import MATERIAL_WORDS, Heading, holds_speed, meant, plain, words_for
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.words import listed, nearest

MU = "mu"
GAPS = ("", "nan", "na", "n/a", "-", "--", "#n/a", "#nv")  # what people write where nothing was measured


@dataclass(frozen=True)
class Wanted:
    """What people say of the columns of a table, where the headings do not.

    unit : of the speeds or times. speed, time : heading of that column. friction : headings of those of friction.
    """

    unit: str = ""
    speed: str = ""
    time: str = ""
    friction: tuple[str, ...] = ()


class Role(NamedTuple):
    """What a column of the file is: its position, its row of the vocabulary, its unit as written, the material."""

    position: int
    column: Parameter
    unit: str
    label: str = ""


class Search:
    """Looks for the columns of a table among its headings."""

    def __init__(
        self, table: Table, headings: list[Heading], rows: list[tuple[Cell, ...]],
        columns: Sequence[Parameter], wanted: Wanted,
    ) -> None:  # fmt: skip
        self._table, self._headings, self._rows, self._wanted = table, headings, rows, wanted
        self._known = {column.name: column for column in columns}
        self._told = {"speed": wanted.speed, "time": wanted.time}
        self._free = MU in self._known  # of friction any table is read; others have the columns they must

    def roles(self) -> tuple[list[Role], int | None]:
        """The role of each column that is used, and the position of that which names materials. Raises ConfigError."""
        found: dict[str, Role] = {}
        problems: list[Problem] = []
        others: list[int] = []
        for i, one in enumerate(self._headings):
            name = self._meant(one)
            try:
                if name is None:
                    if not self._free:
                        raise self._unknown(one.name)
                    others.append(i)
                elif name in found:
                    raise QuantityError("it once", "remove one of the two columns")
                else:
                    found[name] = self._role(i, name)
            except QuantityError as error:
                problems.append(self._problem(i, error))
        if problems:
            raise ConfigError(self._table.name, problems)
        if (longer := self._longer(found, others)) is not None:
            others.remove(longer)
            found["speed"] = self._role(longer, "speed")
        frictions = self._frictions(found, others)
        missing = [c for c in self._known.values() if c.default is None and c.name not in found]
        if frictions:
            missing = [column for column in missing if column.name != MU]
        if missing:
            raise ConfigError(self._table.name, [self._lacking(missing, others)])
        named = [i for i in others if plain(self._headings[i].name) in MATERIAL_WORDS and not self._is_numbers(i)]
        group = named[0] if len(frictions) < 2 and len(named) == 1 else None
        shared = [role for name, role in found.items() if name != MU]
        order = [*self._known]
        return sorted([*shared, *frictions], key=lambda role: order.index(role.column.name)), group

    def _meant(self, one: Heading) -> str | None:
        """The column that a heading is, by what people said, else by its name."""
        for name, told in self._told.items():
            if told and name in self._known and one.is_called(told):
                return name
        usual = meant(one.name, self._known)
        was_named = usual is not None and (self._told.get(usual) or usual == MU and self._wanted.friction)
        return None if was_named else usual

    def _longer(self, found: Mapping[str, Role], others: list[int]) -> int | None:
        """The only column whose longer heading speaks of a speed, where none is called so and no unit denies it."""
        if "speed" not in self._known or "speed" in found or not self._free:
            return None
        named = [i for i in others if holds_speed(self._headings[i].name)]
        if len(named) != 1 or self._told["speed"]:
            return None
        unit = self._headings[named[0]].unit or self._wanted.unit
        return named[0] if not unit or is_unit_of(unit, self._known["speed"]) else None

    def _role(self, i: int, name: str) -> Role:
        """Raises QuantityError for the wrong unit."""
        column, one = self._known[name], self._headings[i]
        unit = one.unit or (self._wanted.unit if column.units != "1" else "")
        check_unit(unit, column)
        return Role(i, column, "" if column.units == "1" else unit)

    def _frictions(self, found: dict[str, Role], others: list[int]) -> list[Role]:
        """The columns of friction: those named, else the one called so, else all that may be. Raises ConfigError."""
        if not self._free:
            return []
        column = self._known[MU]
        if self._wanted.friction:
            chosen = [self._called(word) for word in self._wanted.friction]
            plain_one = len(chosen) == 1 and meant(self._headings[chosen[0]].name, self._known) == MU
            return [Role(i, column, "", "" if plain_one else self._headings[i].name) for i in chosen]
        if MU in found:
            return [found[MU]]
        has_place = any(c.units != "1" and c.name in found for c in self._known.values())
        wide = [i for i in others if self._headings[i].may_be_friction() and self._has_numbers(i)] if has_place else []
        return [Role(i, column, "", self._headings[i].name) for i in wide]

    def _called(self, word: str) -> int:
        """The position of the column that people call so. Raises ConfigError."""
        found = [i for i, one in enumerate(self._headings) if one.is_called(word)]
        if len(found) == 1:
            return found[0]
        names = listed([repr(one.text) for one in self._headings])
        message = f"{'no' if not found else len(found)} column{'s are' if len(found) > 1 else ' is'} called {word!r}"
        raise ConfigError(self._table.name, [Problem((), f"{message}, expected {names}", self._first())])

    def _is_numbers(self, i: int) -> bool:
        return all(_may_be_number(row[i].text) or row[i].text.lower() in GAPS for row in self._rows if i < len(row))

    def _has_numbers(self, i: int) -> bool:
        return any(_may_be_number(row[i].text) for row in self._rows if i < len(row))

    def _first(self) -> Place:
        return Place(self._table.heading[0].place.line, 1)

    def _problem(self, i: int, error: QuantityError) -> Problem:
        cell = self._table.heading[i]
        return Problem((), f"got {cell.text!r}, expected {error.expected}", cell.place, error.hint)

    def _unknown(self, name: str) -> QuantityError:
        """What is said of a heading that is no column."""
        near = nearest(name, self._known)
        names = listed([c.name for c in self._known.values()])
        remedy = f"did you mean {near!r}?" if near else "the first line names the columns; remarks start with #"
        if self._free and not near:
            remedy += "; columns of other names are taken by --speed-column and --friction-column"
        return QuantityError(f"{names}, with the unit in brackets", remedy)

    def _lacking(self, missing: list[Parameter], others: list[int]) -> Problem:
        """Columns that are not there, with the heading that was perhaps meant."""
        told = {plain(word) for word in words_for([column.name for column in missing])}
        for i in others:
            if nearest(self._headings[i].name, [word for word in told if len(word) > 2]):
                return self._problem(i, self._unknown(self._headings[i].name))
        all_of_them = len(missing) == sum(column.default is None for column in self._known.values())
        if all_of_them and others and (not self._free or _may_be_number(self._headings[others[0]].text)):
            return self._problem(others[0], self._unknown(self._headings[others[0]].name))
        lacking = listed([f"{c.name} ({c.long_name})" for c in missing], "and")
        options = [f"--{'friction' if c.name == MU else c.name}-column" for c in missing]
        hint = f"the first line that is not a comment says, for instance, '{example([*self._known.values()])}'"
        if others:
            hint += f"; stickslip fit takes columns of other names by {listed(options, 'and')}"
        return Problem((), f"no column is called {lacking}", self._first(), hint)


def _may_be_number(text: str) -> bool:
    return bool(NUMBER.fullmatch(text) or DECIMAL_COMMA.fullmatch(text))


def is_unit_of(text: str, row: Parameter) -> bool:
    """Whether a text is a unit of a column."""
    try:
        check_unit(text, row)
    except QuantityError:
        return False
    return bool(text)


def check_unit(unit: str, column: Parameter) -> None:
    """Raises QuantityError if a unit is not one of this column."""
    if column.units == "1":
        if unit not in ("", "1", "-"):
            raise QuantityError("no unit", f"{column.name} is a pure number")
        return
    if not unit:
        return
    try:
        units.si_value(f"1 {unit}", column.units)
    except QuantityError as error:
        hint = f"{unit} is a unit of {error.found}" if error.found else error.hint
        raise QuantityError(f"the unit of {units.kind(column.units)}", hint) from None


def example(columns: Sequence[Parameter]) -> str:
    """A line that names the columns there must be."""
    return ", ".join(titled(column) for column in columns if column.default is None)


def titled(column: Parameter) -> str:
    """The name of a column with a unit that people use: ``speed [mm/s]``."""
    return f"{column.name} [{units.example(column.units).split(' ', 1)[1]}]" if column.units != "1" else column.name
