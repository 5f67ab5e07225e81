"""What the columns of a table are: those that people name, those of known headings, else the materials."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import DECIMAL_COMMA, NUMBER, Cell, Table
from stickslip.fit.headings import PERCENT, PURE, Heading, heading, plain, trailing_unit, words_for
from stickslip.fit.loads import load_above, newtons
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import column_unit, is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.suggest import listed, nearest

MU, SIGMA = "mu", "sigma"
WHOLE = re.compile(r"([-+]?\d+)(?:[.,]0*)?")  # workbooks write 1.0
GAPS = ("", "nan", "na", "n/a", "-", "--", "#n/a", "#nv")  # what people write where nothing was measured
MOST_FRICTION = 2.0  # of a column whose heading says nothing; more is rather a percentage, or something else
_ALIKE = 3.0  # ratio of the largest numbers of two columns of one name; a standard deviation is less


@dataclass(frozen=True)
class Wanted:
    """What people say of the columns of a table, where the headings do not.

    unit : of the speeds or times. speed, time : heading of that column. friction : headings of those of friction.
    load : normal load by which friction forces are divided, in N or with a unit.
    """

    unit: str = ""
    speed: str = ""
    time: str = ""
    friction: tuple[str, ...] = ()
    load: float | str | None = None


class Role(NamedTuple):
    """What a column of the file is: its position, its row of the vocabulary, its unit, the material.

    load : what friction forces are divided by: the position and the unit of a column, or a force in N.
    """

    position: int
    column: Parameter
    unit: str
    label: str = ""
    load: tuple[int, str] | float | None = None


class Found(NamedTuple):
    """The roles of the columns, the position of that which names materials, and remarks on what was taken."""

    roles: list[Role]
    group: int | None
    notes: tuple[str, ...]


class Search:
    """Looks for the columns of a table among its headings."""

    def __init__(
        self, table: Table, headings: list[Heading], rows: list[tuple[Cell, ...]],
        columns: Sequence[Parameter], wanted: Wanted,
    ) -> None:  # fmt: skip
        self._table, self._headings, self._rows, self._wanted = table, headings, rows, wanted
        self._known = {column.name: column for column in columns}
        self._named = {name: word for name, word in (("speed", wanted.speed), ("time", wanted.time)) if word}
        self._notes: list[str] = []

    def roles(self) -> Found:
        """The role of each column that is used. Raises ConfigError."""
        if MU not in self._known:
            return Found(self._all_known(), None, ())
        roles = [role for name in self._known if name not in (MU, SIGMA) and (role := self._one(name)) is not None]
        used = {role.position for role in roles}
        frictions = self._frictions(used)
        lacking = [c for c in self._known.values() if c.name not in (MU, SIGMA, *(r.column.name for r in roles))]
        lacking += [] if frictions else [self._known[MU]]
        if lacking:
            raise ConfigError(self._table.name, [self._lacking(lacking, used)])
        frictions = [self._divided(role) for role in frictions]
        deviations = self._deviations(frictions) if SIGMA in self._known else []
        return Found([*roles, *frictions, *deviations], self._group(), tuple(self._notes))

    # --- speed or time ------------------------------------------------------------------------------------------------

    def _one(self, name: str) -> Role | None:
        """The column of speeds or times; None if there is none. Raises ConfigError where several may be meant."""
        column = self._known[name]
        if word := self._named.get(name):
            i = self._called(word)
            unit = self._headings[i].unit or trailing_unit(self._headings[i].text, column.units)
            unit = unit or "".join(re.findall(r"[(\[].*[)\]]", self._headings[i].text))
            if self._wanted.unit and not is_column_unit(unit, column.units):
                unit = ""
            return Role(i, column, self._unit(i, unit, column))
        exact = [i for i, one in enumerate(self._headings) if one.kind == name and not one.label]
        longer = [i for i, one in enumerate(self._headings) if one.kind == name and one.label]
        for among in (exact, longer):
            sure = [i for i in among if self._headings[i].unit and is_column_unit(self._headings[i].unit, column.units)]
            open_ones = [i for i in among if not self._headings[i].unit]
            chosen = sure or open_ones or (among if among is exact else [])
            if len(chosen) > 1 or len(chosen) == 1 and chosen == sure and len(open_ones) > 0:
                text = self._headings[among[0]].text
                hint = f"remove one of the two columns, or name the one to take: --{name}-column '{text}'"
                raise self._refused(among[1], "it once", hint)
            if chosen:
                return Role(chosen[0], column, self._unit(chosen[0], self._headings[chosen[0]].unit, column))
        return None

    def _unit(self, i: int, unit: str, column: Parameter) -> str:
        """The unit of a column, in symbols. Raises ConfigError."""
        try:
            unit = unit or (self._wanted.unit if column.units != "1" else "")
            return unit_of(unit, column)
        except QuantityError as error:
            raise ConfigError(self._table.name, [self._problem(i, error)]) from None

    # --- friction -----------------------------------------------------------------------------------------------------

    def _frictions(self, used: set[int]) -> list[Role]:
        """The columns of friction: those named, else those of friction, else all that may be. Raises ConfigError."""
        if self._wanted.friction:
            chosen = [self._called(word) for word in self._wanted.friction]
            return [self._friction(i, len(chosen) > 1 or not self._headings[i].kind) for i in chosen]
        rest = [i for i, one in enumerate(self._headings) if i not in used and one.text]
        if (one := self._unlabelled(rest)) is not None:
            return [self._friction(one, False)]
        rest = [i for i in rest if self._has_numbers(i)]
        over_speed = "speed" in self._known
        wanted_kinds = (MU, "kinetic") if over_speed else (MU, "static")
        of_materials = [i for i in rest if self._headings[i].kind in wanted_kinds and self._headings[i].label]
        forces = [i for i in rest if self._headings[i].kind == "friction_force"]
        if not of_materials and forces:
            return [self._friction(i, len(forces) > 1) for i in forces]
        if not used:
            return []
        unnamed = [i for i in rest if self._headings[i].kind in ("", "material") and self._headings[i].unit in PURE]
        unknown = [i for i in unnamed if not self._is_count(i) and (self._is_numbers(i) or not self._headings[i].kind)]
        names = [plain(self._headings[i].name) for i in unknown]
        spreads = {start + name for name in names for start in ("s ", "s", "u ", "u", "d ", "d", "δ", "σ")}
        unknown = [i for i, name in zip(unknown, names, strict=True) if name not in spreads]  # s_A beside A
        if of_materials:  # others beside them, which are too large, are something else
            unknown = [i for i in unknown if self._largest(i) <= MOST_FRICTION]
        return self._repeated([self._friction(i, True) for i in sorted([*of_materials, *unknown])])

    def _unlabelled(self, rest: list[int]) -> int | None:
        """The column of friction as such, of which a table has one. Raises ConfigError where it is not certain."""
        by_kind = {kind: [i for i in rest if self._headings[i].kind == kind and not self._headings[i].label]
                   for kind in (MU, "kinetic", "static")}  # fmt: skip
        over_speed = "speed" in self._known
        fitting, other = ("kinetic", "static") if over_speed else ("static", "kinetic")
        if len(by_kind[MU]) > 1:
            raise self._refused(by_kind[MU][1], "it once", _NAME_ONE)
        chosen = [*by_kind[MU], *by_kind[fitting]]
        if len(chosen) > 1 or not chosen and by_kind[other]:
            i = (chosen or by_kind[other])[0]
            what = (
                "one column of friction" if chosen else f"{fitting} friction over {'speed' if over_speed else 'time'}"
            )
            raise self._refused(i, what, _NAME_ONE)
        for i in by_kind[other] if chosen else []:
            self._notes.append(f"{self._headings[i].text!r} is {other} friction and not used")
        return chosen[0] if chosen else None

    def _repeated(self, roles: list[Role]) -> list[Role]:
        """Columns of materials, those of one heading being repeats. Raises ConfigError where they are not alike."""
        error = QuantityError("another name than the first column of this name, which holds other numbers")
        for role in roles:
            alike = [one.position for one in roles if one.label == role.label]
            largest = sorted(self._largest(i) for i in alike)
            if largest[-1] > _ALIKE * largest[0]:
                raise ConfigError(self._table.name, [self._problem(alike[1], error)])
            if len(alike) > 1 and role.position == alike[0]:
                self._notes.append(f"the {len(alike)} columns called {role.label!r} are repeats")
        return roles

    def _friction(self, i: int, is_material: bool) -> Role:
        """A column of friction coefficients, or of forces. Raises ConfigError."""
        one, column = self._headings[i], self._known[MU]
        label = one.text if is_material else ""
        if one.is_force() or one.unit and one.kind in ("", "other") and is_column_unit(one.unit, "N"):
            return Role(i, column, self._newtons(i), label, 0.0)
        if one.unit in PURE or plain(one.unit) in PERCENT:
            return Role(i, column, "" if one.unit in PURE else "%", label)
        raise self._refused(i, "no unit", f"{MU} is a pure number, or in %")

    def _divided(self, role: Role) -> Role:
        """A column of friction forces with the load they are divided by. Raises ConfigError."""
        if role.load is None:
            return role
        text = self._headings[role.position].text
        loads = [
            i
            for i, one in enumerate(self._headings)
            if one.kind == "load" and not one.label and i != role.position and self._has_numbers(i)
        ]
        if len(loads) == 1:
            self._notes.append(f"{text!r} is divided by {self._headings[loads[0]].text!r}")
            return role._replace(load=(loads[0], self._newtons(loads[0])))
        if not loads and (above := load_above(self._table)) is not None:
            load, line = above
            self._notes.append(f"{text!r} is divided by {load:g} N (line {line})")
            return role._replace(load=load)
        if not loads and self._wanted.load is not None:
            load = newtons(self._wanted.load)
            self._notes.append(f"{text!r} is divided by {load:g} N (--load)")
            return role._replace(load=load)
        several = "one column of loads" if loads else "a friction coefficient, or a load to divide this force by"
        hint = "give the load: a column 'Load [N]', a line 'Load;15;N' above the heading, or --load '15 N'"
        raise self._refused(role.position, several, hint)

    def _newtons(self, i: int) -> str:
        """The unit of a column of forces, which must have one. Raises ConfigError."""
        try:
            return column_unit(self._headings[i].unit, "N")
        except QuantityError as error:
            hint = error.hint if self._headings[i].unit else "write it in brackets: 'Force [N]'"
            raise self._refused(i, "the unit of a force", hint) from None

    # --- standard deviations, materials -------------------------------------------------------------------------------

    def _deviations(self, frictions: list[Role]) -> list[Role]:
        """The columns of standard deviations that belong to one of friction. Raises ConfigError."""
        sigmas = [i for i, one in enumerate(self._headings) if one.kind == SIGMA and self._has_numbers(i)]
        bare = [i for i in sigmas if not self._headings[i].label]
        if len(frictions) == 1 and not frictions[0].label and len(bare) > 1:
            raise self._refused(bare[1], "it once", "remove one of the two")
        found = []
        for role in frictions:
            own = bare if not role.label else [i for i in sigmas if self._belongs(i, role)]
            if len(own) != 1 or role.load is not None:
                continue
            one = self._headings[own[0]]
            unit = "%" if plain(one.unit) in PERCENT else one.unit
            is_pure = unit in PURE and not role.unit or unit == role.unit
            is_whole = not role.label or all(
                self._is_positive(row, own[0]) for row in self._rows if self._is_there(row, role.position)
            )
            if is_pure and is_whole:
                found.append(Role(own[0], self._known[SIGMA], role.unit, role.label))
                if role.label:
                    self._notes.append(f"{one.text!r} is the standard deviation of {role.label!r}")
        return found

    def _belongs(self, i: int, role: Role) -> bool:
        """Whether a column of standard deviations is called after one of friction, and after no other."""
        label, one = plain(self._headings[i].label), self._headings[role.position]
        names = {plain(one.name), plain(one.text), plain(one.label)} - {""}
        short = {plain(heading(one.name).label or one.name)}
        return bool(label) and label in names | short

    def _group(self) -> int | None:
        """The column that tells materials apart: of names, or of numbers that occur again."""
        columns = [i for i, one in enumerate(self._headings) if one.kind == "material" and not one.unit and one.text]
        named = [i for i in columns if not self._is_numbers(i)]
        counted = [i for i in columns if i not in named and self._is_count(i) and not self._is_distinct(i)]
        group = named or counted
        return group[0] if len(group) == 1 else None

    # --- what stands in the columns -----------------------------------------------------------------------------------

    def _texts(self, i: int) -> list[str]:
        """What a column holds, without gaps."""
        return [row[i].text for row in self._rows if i < len(row) and row[i].text.lower() not in GAPS]

    def _is_numbers(self, i: int) -> bool:
        return all(map(_may_be_number, self._texts(i)))

    def _has_numbers(self, i: int) -> bool:
        return any(map(_may_be_number, self._texts(i)))

    def _is_count(self, i: int) -> bool:
        """Whether a column holds whole numbers only, as no friction does."""
        return all(map(WHOLE.fullmatch, self._texts(i)))

    def _is_distinct(self, i: int) -> bool:
        return len(set(self._texts(i))) == len(self._texts(i))

    def _largest(self, i: int) -> float:
        """The largest number of a column; the texts are read exactly later."""
        numbers = (text.replace(",", ".") for text in self._texts(i))
        return max((abs(float(text)) for text in numbers if NUMBER.fullmatch(text)), default=0.0)

    def _is_there(self, row: tuple[Cell, ...], i: int) -> bool:
        return i < len(row) and row[i].text.lower() not in GAPS

    def _is_positive(self, row: tuple[Cell, ...], i: int) -> bool:
        text = row[i].text.replace(",", ".") if i < len(row) else ""
        return bool(NUMBER.fullmatch(text)) and float(text) > 0

    # --- what is wrong ------------------------------------------------------------------------------------------------

    def _called(self, word: str) -> int:
        """The position of the column that people call so. Raises ConfigError."""
        found = [i for i, one in enumerate(self._headings) if one.is_called(word)]
        if len(found) == 1:
            return found[0]
        names = listed([repr(one.text) for one in self._headings])
        message = f"{'no' if not found else len(found)} column{'s are' if len(found) > 1 else ' is'} called {word!r}"
        raise ConfigError(self._table.name, [Problem((), f"{message}, expected {names}", self._first())])

    def _all_known(self) -> list[Role]:
        """The roles of a table that has no other columns than the known ones. Raises ConfigError."""
        found: dict[str, Role] = {}
        problems: list[Problem] = []
        for i, one in enumerate(self._headings):
            try:
                if one.kind not in self._known:
                    raise self._unknown(one.name)
                if one.kind in found:
                    raise QuantityError("it once", "remove one of the two columns")
                found[one.kind] = Role(i, self._known[one.kind], unit_of(one.unit, self._known[one.kind]))
            except QuantityError as error:
                problems.append(self._problem(i, error))
        missing = [c for c in self._known.values() if c.default is None and c.name not in found]
        if missing and not problems:
            problems = [self._lacking(missing, {role.position for role in found.values()})]
        if problems:
            raise ConfigError(self._table.name, problems)
        return [found[name] for name in self._known if name in found]

    def _first(self) -> Place:
        return Place(self._table.heading[0].place.line, 1)

    def _problem(self, i: int, error: QuantityError) -> Problem:
        cell = self._table.heading[i]
        return Problem((), f"got {cell.text!r}, expected {error.expected}", cell.place, error.hint)

    def _refused(self, i: int, expected: str, hint: str | None = None) -> ConfigError:
        """That a column is not what it should be."""
        return ConfigError(self._table.name, [self._problem(i, QuantityError(expected, hint))])

    def _unknown(self, name: str) -> QuantityError:
        """What is said of a heading that is no column."""
        near = nearest(name, self._known)
        names = listed([c.name for c in self._known.values()])
        remedy = f"did you mean {near!r}?" if near else "the first line names the columns; remarks start with #"
        if MU in self._known and not near:
            remedy += "; columns of other names are taken by --speed-column and --friction-column"
        return QuantityError(f"{names}, with the unit in brackets", remedy)

    def _lacking(self, missing: list[Parameter], used: set[int]) -> Problem:
        """Columns that are not there, with the heading that was perhaps meant."""
        known = [word for word in map(plain, words_for([column.name for column in missing])) if len(word) > 2]
        others = [
            i
            for i, one in enumerate(self._headings)
            if i not in used and one.text and (one.label or one.kind not in self._known)
        ]
        for i in others:
            if nearest(self._headings[i].name, known):
                return self._problem(i, self._unknown(self._headings[i].name))
        all_of_them = len(missing) == sum(column.default is None for column in self._known.values())
        if all_of_them and others and (MU not in self._known or _may_be_number(self._headings[others[0]].text)):
            return self._problem(others[0], self._unknown(self._headings[others[0]].name))
        lacking = listed([f"{c.name} ({c.long_name})" for c in missing], "and")
        unknown = f"; not understood: {listed([repr(self._headings[i].text) for i in others], 'and')}" if others else ""
        likely = [i for i in others if is_column_unit(self._headings[i].unit, missing[0].units)]
        hint = f"the first line that is not a comment says, for instance, '{example([*self._known.values()])}'"
        if MU in self._known and others:
            word = self._headings[likely[0]].text if len(likely) == 1 else "HEADING"
            options = [
                "--friction-column 'HEADING'" if c.name == MU else f"--{c.name}-column '{word}'" for c in missing
            ]
            hint = f"columns of other names are taken by {listed(options, 'and')}"
        return Problem((), f"no column is called {lacking}{unknown}", self._first(), hint)


_NAME_ONE = "remove one of the two columns, or name the one to take, such as --friction-column 'mu_k'"


def _may_be_number(text: str) -> bool:
    return bool(NUMBER.fullmatch(text) or DECIMAL_COMMA.fullmatch(text))


def unit_of(unit: str, column: Parameter) -> str:
    """A unit as written, in symbols; nothing for pure numbers. Raises QuantityError if it is not one of this column."""
    if column.units == "1":
        if unit not in PURE:
            raise QuantityError("no unit", f"{column.name} is a pure number")
        return ""
    return column_unit(unit, column.units) if unit else ""


def example(columns: Sequence[Parameter]) -> str:
    """A line that names the columns there must be."""
    return ", ".join(titled(column) for column in columns if column.default is None)


def titled(column: Parameter) -> str:
    """The name of a column with a unit that people use: ``speed [mm/s]``."""
    return f"{column.name} [{units.example(column.units).split(' ', 1)[1]}]" if column.units != "1" else column.name
