"""Columns of a table of points: those that people name, those of known headings, else the materials.

Friction forces are divided by a column of loads, a line above the heading (`Prüflast;15;N`), or the load of the caller.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.errors import ConfigError, QuantityError
from stickslip.files.tables import DECIMAL_COMMA, NUMBER, Cell
from stickslip.fit.columns import HeadedTable, example, load_above, newtons
from stickslip.fit.headings import PERCENT, PURE, heading, plain, trailing_unit, words_for
from stickslip.vocabulary.column_units import column_unit, is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.suggest import listed, nearest

MU, SIGMA = "mu", "sigma"
WHOLE = re.compile(r"([-+]?\d+)(?:[.,]0*)?")  # workbooks write 1.0
GAPS = ("", "nan", "na", "n/a", "-", "--", "#n/a", "#nv")  # what people write where nothing was measured
MOST_FRICTION = 2.0  # of a column whose heading says nothing; more is rather a percentage, or something else
_ALIKE = 3.0  # ratio of the largest numbers of two columns of one name; a standard deviation is less
_NAME_ONE = "remove one of the two columns, or name the one to take, such as --friction-column 'mu_k'"


@dataclass(frozen=True)
class Wanted:
    """Columns of a table as people name them, where the headings do not.

    unit : of the speeds or times. speed, time : heading of that column. friction : headings of those of friction.
    load : normal load by which friction forces are divided, in N or with a unit.
    """

    unit: str = ""
    speed: str = ""
    time: str = ""
    friction: tuple[str, ...] = ()
    load: float | str | None = None


class Role(NamedTuple):
    """A column of the file: its position, its row of the vocabulary, its unit, the material.

    load : by which friction forces are divided: the position and the unit of a column, or a force in N.
    """

    position: int
    column: Parameter
    unit: str
    label: str = ""
    load: tuple[int, str] | float | None = None


class Roles(NamedTuple):
    """The roles of the columns, the position of that which names materials, and remarks on what was taken."""

    roles: list[Role]
    group: int | None
    notes: tuple[str, ...]


class Search:
    """Looks for the columns of a table among its headings.

    columns : the one of speeds or times, that of friction, and perhaps that of its standard deviations.
    """

    def __init__(
        self, table: HeadedTable, rows: list[tuple[Cell, ...]], columns: Sequence[Parameter], wanted: Wanted
    ) -> None:
        self._table, self._headings, self._rows, self._wanted = table, table.headings, rows, wanted
        self._known = {column.name: column for column in columns}
        self._along = columns[0]
        self._texts = [[row[i].text for row in rows if _is_there(row, i)] for i in range(len(table.headings))]
        self._notes: list[str] = []

    def roles(self) -> Roles:
        """The role of each column that is used. Raises ConfigError."""
        along = self._speed_or_time()
        used = set() if along is None else {along.position}
        frictions = self._frictions(used)
        lacking = [self._along] if along is None else []
        lacking += [] if frictions else [self._known[MU]]
        if lacking or along is None:
            raise self._lacking(lacking, used)
        frictions = [self._divided(role) for role in frictions]
        deviations = self._deviations(frictions) if SIGMA in self._known else []
        return Roles([along, *frictions, *deviations], self._group(), tuple(self._notes))

    # --- speed or time ------------------------------------------------------------------------------------------------

    def _speed_or_time(self) -> Role | None:
        """The column of speeds or times; None if there is none. Raises ConfigError where several may be meant."""
        column, headings = self._along, self._headings
        if word := self._wanted.speed if column.name == "speed" else self._wanted.time:
            i = self._named(word)
            text = headings[i].text
            unit = headings[i].unit or trailing_unit(text, column.units) or "".join(re.findall(r"[(\[].*[)\]]", text))
            if self._wanted.unit and not is_column_unit(unit, column.units):
                unit = ""
            return Role(i, column, self._unit(i, unit, column.units))
        of_kind = [i for i, one in enumerate(headings) if one.kind == column.name]
        exact = [i for i in of_kind if not headings[i].label]
        for among in (exact, [i for i in of_kind if i not in exact]):
            sure = [i for i in among if headings[i].unit and is_column_unit(headings[i].unit, column.units)]
            without_unit = [i for i in among if not headings[i].unit]
            chosen = sure or without_unit or (among if among is exact else [])
            if len(chosen) > 1 or sure and without_unit:
                option = f"--{column.name}-column '{headings[among[0]].text}'"
                raise self._table.refused(
                    among[1], "it once", f"remove one of the two columns, or name the one to take: {option}"
                )
            if chosen:
                return Role(chosen[0], column, self._unit(chosen[0], headings[chosen[0]].unit, column.units))
        return None

    def _unit(self, i: int, unit: str, of: str) -> str:
        unit = unit or self._wanted.unit
        try:
            return column_unit(unit, of) if unit else ""
        except QuantityError as error:
            raise self._table.refused(i, error.expected, error.hint) from None

    # --- friction -----------------------------------------------------------------------------------------------------

    def _frictions(self, used: set[int]) -> list[Role]:
        """The columns of friction: those named, else those of friction, else all that may be. Raises ConfigError."""
        headings, over_speed = self._headings, self._along.name == "speed"
        if self._wanted.friction:
            chosen = [self._named(word) for word in self._wanted.friction]
            return [self._friction(i, len(chosen) > 1 or not headings[i].kind) for i in chosen]
        rest = [i for i, one in enumerate(headings) if i not in used and one.text]
        if (single := self._unlabelled(rest)) is not None:
            return [self._friction(single, False)]
        rest = [i for i in rest if self._has_numbers(i)]
        kinds = (MU, "kinetic") if over_speed else (MU, "static")
        of_materials = [i for i in rest if headings[i].kind in kinds and headings[i].label]
        forces = [i for i in rest if headings[i].kind == "friction_force"]
        if not of_materials and forces:
            return [self._friction(i, len(forces) > 1) for i in forces]
        if not used:
            return []
        unknown = [i for i in rest if headings[i].kind in ("", "material") and headings[i].unit in PURE]
        unknown = [i for i in unknown if not self._is_count(i) and (self._is_numbers(i) or not headings[i].kind)]
        names = {i: plain(headings[i].name) for i in unknown}
        spreads = {start + name for name in names.values() for start in ("s ", "s", "u ", "u", "d ", "d", "δ", "σ")}
        unknown = [i for i, name in names.items() if name not in spreads]  # s_A beside A
        if of_materials:  # others beside them, which are too large, are something else
            unknown = [i for i in unknown if self._largest(i) <= MOST_FRICTION]
        return self._repeated([self._friction(i, True) for i in sorted([*of_materials, *unknown])])

    def _unlabelled(self, rest: list[int]) -> int | None:
        """The column of friction as such, of which a table has one. Raises ConfigError where it is not certain."""
        by_kind = {kind: [i for i in rest if self._headings[i].kind == kind and not self._headings[i].label]
                   for kind in (MU, "kinetic", "static")}  # fmt: skip
        over_speed = self._along.name == "speed"
        fitting, other = ("kinetic", "static") if over_speed else ("static", "kinetic")
        if len(by_kind[MU]) > 1:
            raise self._table.refused(by_kind[MU][1], "it once", _NAME_ONE)
        chosen = [*by_kind[MU], *by_kind[fitting]]
        if len(chosen) > 1:
            raise self._table.refused(chosen[0], "one column of friction", _NAME_ONE)
        if not chosen and by_kind[other]:
            raise self._table.refused(by_kind[other][0], f"{fitting} friction over {self._along.name}", _NAME_ONE)
        for i in by_kind[other]:
            self._notes.append(f"{self._headings[i].text!r} is {other} friction and not used")
        return chosen[0] if chosen else None

    def _repeated(self, roles: list[Role]) -> list[Role]:
        """Columns of materials, those of one heading being repeats. Raises ConfigError where they are not alike."""
        for role in roles:
            alike = [other.position for other in roles if other.label == role.label]
            largest = sorted(self._largest(i) for i in alike)
            if largest[-1] > _ALIKE * largest[0]:
                raise self._table.refused(
                    alike[1], "another name than the first column of this name, which holds other numbers"
                )
            if len(alike) > 1 and role.position == alike[0]:
                self._notes.append(f"the {len(alike)} columns called {role.label!r} are repeats")
        return roles

    def _friction(self, i: int, is_material: bool) -> Role:
        one, column = self._headings[i], self._known[MU]
        label = one.text if is_material else ""
        if one.is_force() or one.unit and one.kind in ("", "other") and is_column_unit(one.unit, "N"):
            return Role(i, column, self._newtons(i), label, 0.0)
        if one.unit in PURE or plain(one.unit) in PERCENT:
            return Role(i, column, "" if one.unit in PURE else "%", label)
        raise self._table.refused(i, "no unit", f"{MU} is a pure number, or in %")

    def _divided(self, role: Role) -> Role:
        """A column of friction forces with the load they are divided by. Raises ConfigError."""
        if role.load is None:
            return role
        loads = [i for i, one in enumerate(self._headings)
                 if one.kind == "load" and not one.label and i != role.position and self._has_numbers(i)]  # fmt: skip
        if len(loads) == 1:
            load: tuple[int, str] | float = (loads[0], self._newtons(loads[0]))
            shown = repr(self._headings[loads[0]].text)
        elif not loads and (above := load_above(self._table.table)) is not None:
            load, shown = above[0], f"{above[0]:g} N (line {above[1]})"
        elif not loads and self._wanted.load is not None:
            load = newtons(self._wanted.load)
            shown = f"{load:g} N (--load)"
        else:
            expected = "one column of loads" if loads else "a friction coefficient, or a load to divide this force by"
            hint = "give the load: a column 'Load [N]', a line 'Load;15;N' above the heading, or --load '15 N'"
            raise self._table.refused(role.position, expected, hint)
        self._notes.append(f"{self._headings[role.position].text!r} is divided by {shown}")
        return role._replace(load=load)

    def _newtons(self, i: int) -> str:
        try:
            return column_unit(self._headings[i].unit, "N")
        except QuantityError as error:
            hint = error.hint if self._headings[i].unit else "write it in brackets: 'Force [N]'"
            raise self._table.refused(i, "the unit of a force", hint) from None

    # --- standard deviations, materials -------------------------------------------------------------------------------

    def _deviations(self, frictions: list[Role]) -> list[Role]:
        """The columns of standard deviations that belong to one of friction. Raises ConfigError."""
        sigmas = [i for i, one in enumerate(self._headings) if one.kind == SIGMA and self._has_numbers(i)]
        bare = [i for i in sigmas if not self._headings[i].label]
        if len(frictions) == 1 and not frictions[0].label and len(bare) > 1:
            raise self._table.refused(bare[1], "it once", "remove one of the two")
        deviations = []
        for role in frictions:
            own = bare if not role.label else [i for i in sigmas if self._belongs(i, role)]
            if len(own) != 1 or role.load is not None:
                continue
            i, text, unit = own[0], self._headings[own[0]].text, self._headings[own[0]].unit
            unit = "%" if plain(unit) in PERCENT else unit
            is_pure = unit in PURE and not role.unit or unit == role.unit
            is_whole = not role.label or all(
                i < len(row) and _size(row[i].text, signed=True) > 0
                for row in self._rows
                if _is_there(row, role.position)
            )
            if is_pure and is_whole:
                deviations.append(Role(i, self._known[SIGMA], role.unit, role.label))
                self._notes += [f"{text!r} is the standard deviation of {role.label!r}"] if role.label else []
        return deviations

    def _belongs(self, i: int, role: Role) -> bool:
        """True for a column of standard deviations that is called after one of friction."""
        label, one = plain(self._headings[i].label), self._headings[role.position]
        names = (one.name, one.text, one.label, heading(one.name).label or one.name)
        return bool(label) and label in map(plain, names)

    def _group(self) -> int | None:
        columns = [i for i, one in enumerate(self._headings) if one.kind == "material" and not one.unit and one.text]
        named = [i for i in columns if not self._is_numbers(i)]
        counted = [i for i in columns if self._is_count(i) and len({*self._texts[i]}) < len(self._texts[i])]
        group = named or counted
        return group[0] if len(group) == 1 else None

    def _is_numbers(self, i: int) -> bool:
        return all(map(_may_be_number, self._texts[i]))

    def _has_numbers(self, i: int) -> bool:
        return any(map(_may_be_number, self._texts[i]))

    def _is_count(self, i: int) -> bool:
        """True for a column of whole numbers only, as no friction has."""
        return all(map(WHOLE.fullmatch, self._texts[i]))

    def _largest(self, i: int) -> float:
        return max(map(_size, self._texts[i]), default=0.0)

    # --- what is wrong ------------------------------------------------------------------------------------------------

    def _named(self, word: str) -> int:
        called = [i for i, one in enumerate(self._headings) if one.is_called(word)]
        if len(called) == 1:
            return called[0]
        names = listed([repr(one.text) for one in self._headings])
        count = f"{len(called)} columns are" if called else "no column is"
        raise self._table.error(f"{count} called {word!r}, expected {names}")

    def _unknown(self, i: int) -> ConfigError:
        near = nearest(self._headings[i].name, self._known)
        hint = "the first line names the columns; remarks start with #; columns of other names are taken by "
        hint = f"did you mean {near!r}?" if near else f"{hint}--speed-column and --friction-column"
        return self._table.refused(i, f"{listed([*self._known])}, with the unit in brackets", hint)

    def _lacking(self, missing: list[Parameter], used: set[int]) -> ConfigError:
        """An error about columns that are not there, with the heading that was perhaps meant."""
        headings = self._headings
        known = [word for word in map(plain, words_for([column.name for column in missing])) if len(word) > 2]
        others = [i for i, one in enumerate(headings)
                  if i not in used and one.text and (one.label or one.kind not in self._known)]  # fmt: skip
        for i in others:
            if nearest(headings[i].name, known):
                return self._unknown(i)
        if len(missing) > 1 and others and _may_be_number(headings[others[0]].text):
            return self._unknown(others[0])
        lacking = listed([f"{c.name} ({c.long_name})" for c in missing], "and")
        unknown = f"; not understood: {listed([repr(headings[i].text) for i in others], 'and')}" if others else ""
        likely = [headings[i].text for i in others if is_column_unit(headings[i].unit, missing[0].units)]
        word = likely[0] if len(likely) == 1 else "HEADING"
        options = ["--friction-column 'HEADING'" if c.name == MU else f"--{c.name}-column '{word}'" for c in missing]
        hint = f"columns of other names are taken by {listed(options, 'and')}"
        if not others:
            hint = f"the first line that is not a comment says, for instance, '{example([*self._known.values()])}'"
        return self._table.error(f"no column is called {lacking}{unknown}", hint)


def _is_there(row: tuple[Cell, ...], i: int) -> bool:
    return i < len(row) and row[i].text.lower() not in GAPS


def _may_be_number(text: str) -> bool:
    return bool(NUMBER.fullmatch(text) or DECIMAL_COMMA.fullmatch(text))


def _size(text: str, signed: bool = False) -> float:
    """A number, 0 where a text is none; read exactly later."""
    text = text.replace(",", ".")
    value = float(text) if NUMBER.fullmatch(text) else 0.0
    return value if signed else abs(value)
