"""Columns of a table of points: those that people name, those of known headings, else the materials.

Friction forces are divided by a column of loads, a line above the heading (`Prüflast;15;N`), or the load of the caller.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.errors import ConfigError, QuantityError
from stickslip.files.layout import NUMBER, is_number
from stickslip.files.tables import Cell
from stickslip.vocabulary.display_units import column_unit, is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.suggest import listed, nearest
from stickslip_materials.fit.columns import MOST_FRICTION, HeadedTable, example, load_above, newtons
from stickslip_materials.fit.headings import Heading, heading, trailing_unit
from stickslip_materials.fit.words import PERCENT, PURE, plain

MU, SIGMA = "mu", "sigma"
WHOLE = re.compile(r"([-+]?\d+)(?:[.,]0*)?")  # workbooks write 1.0
GAPS = ("", "nan", "na", "n/a", "-", "--", "#n/a", "#nv")  # what people write where nothing was measured
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

    @property
    def positions(self) -> tuple[int, ...]:
        """Of the column, and of that of its loads."""
        return (self.position, self.load[0]) if isinstance(self.load, tuple) else (self.position,)


class Roles(NamedTuple):
    """The roles of the columns, the position of that which names materials, and remarks on what was taken."""

    roles: list[Role]
    group: int | None
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Column:
    """A column of the file: its position, its heading, and the texts below it, gaps left out."""

    position: int
    heading: Heading
    texts: list[str]

    @property
    def is_numbers(self) -> bool:
        return all(map(is_number, self.texts))

    @property
    def has_numbers(self) -> bool:
        return any(map(is_number, self.texts))

    @property
    def is_count(self) -> bool:
        """True for a column of whole numbers only, as no friction has."""
        return all(map(WHOLE.fullmatch, self.texts))

    @property
    def may_be_material(self) -> bool:
        """True for numbers that might be the friction of a material called so."""
        head = self.heading
        is_known = head.kind not in ("", "material") or head.unit not in PURE
        return not is_known and not self.is_count and (self.is_numbers or not head.kind)

    @property
    def largest(self) -> float:
        return max((abs(_size(text)) for text in self.texts), default=0.0)


class ColumnSearch:
    """Looks for the columns of a table among its headings.

    columns : the one of speeds or times, that of friction, and perhaps that of its standard deviations.
    """

    def __init__(
        self, table: HeadedTable, rows: list[tuple[Cell, ...]], columns: Sequence[Parameter], wanted: Wanted
    ) -> None:
        self._table, self._rows, self._wanted = table, rows, wanted
        self._known = {column.name: column for column in columns}
        self._along = columns[0]
        self._columns = [
            _Column(i, head, [row[i].text for row in rows if _is_there(row, i)])
            for i, head in enumerate(table.headings)
        ]
        self._notes: list[str] = []

    def roles(self) -> Roles:
        """The role of each column that is used. Raises ConfigError."""
        along = self._speed_or_time()
        others = [column for column in self._columns if along is None or column.position != along.position]
        frictions = self._frictions([column for column in others if column.heading.text], along is not None)
        if along is None or not frictions:
            lacking = [self._along] * (along is None) + [self._known[MU]] * (not frictions)
            raise self._lacking(lacking, others)
        frictions = [role if role.load is None else self._divided(role) for role in frictions]
        deviations = self._deviations(frictions) if SIGMA in self._known else []
        return Roles([along, *frictions, *deviations], self._group(), tuple(self._notes))

    # --- speed or time ------------------------------------------------------------------------------------------------

    def _speed_or_time(self) -> Role | None:
        """The column of speeds or times; None if there is none. Raises ConfigError where several may be meant."""
        name, si, given = self._along.name, self._along.units, self._wanted.unit
        if word := self._wanted.speed if name == "speed" else self._wanted.time:
            column = self._called(word)
            text = column.heading.text
            unit = column.heading.unit or trailing_unit(text, si) or "".join(re.findall(r"[(\[].*[)\]]", text))
            unit = "" if given and not is_column_unit(unit, si) else unit
        elif (i := self._table.pick(name)) is not None:
            column, unit = self._columns[i], self._columns[i].heading.unit
        else:
            return None
        if unit and given and unit != given:
            self._notes.append(f"--unit {given} is not used, since {column.heading.text!r} has a unit")
        unit = unit or given
        try:
            return Role(column.position, self._along, column_unit(unit, si) if unit else "")
        except QuantityError as error:
            raise self._refused(column, error.expected, error.hint) from None

    # --- friction -----------------------------------------------------------------------------------------------------

    def _frictions(self, others: list[_Column], has_along: bool) -> list[Role]:
        """The columns of friction: those named, else those of friction, else all that may be. Raises ConfigError."""
        if self._wanted.friction:
            chosen = [self._called(word) for word in self._wanted.friction]
            return [self._friction(c, len(chosen) > 1 or c.heading.kind in ("", "other")) for c in chosen]
        if (single := self._unlabelled(others)) is not None:
            return [self._friction(single, False)]
        others = [column for column in others if column.has_numbers]
        kinds = (MU, "kinetic" if self._along.name == "speed" else "static")
        of_materials = [column for column in others if column.heading.kind in kinds and column.heading.label]
        forces = [column for column in others if column.heading.kind == "friction_force"]
        if not of_materials and forces:
            return [self._friction(column, len(forces) > 1) for column in forces]
        if not has_along:
            return []
        unknown = [column for column in others if column.may_be_material]
        names = [plain(column.heading.name) for column in unknown]
        spreads = {start + name for name in names for start in ("s ", "s", "u ", "u", "d ", "d", "δ", "σ")}
        unknown = [column for column, name in zip(unknown, names, strict=True) if name not in spreads]  # s_A beside A
        if of_materials:  # others beside them, which are too large, are something else
            unknown = [column for column in unknown if column.largest <= MOST_FRICTION]
        materials = sorted([*of_materials, *unknown], key=lambda column: column.position)
        self._check_repeats(materials)
        return [self._friction(column, True) for column in materials]

    def _unlabelled(self, others: list[_Column]) -> _Column | None:
        """The column of friction as such, of which a table has one. Raises ConfigError where it is not certain."""
        over = self._along.name
        kinds = ("kinetic", "static") if over == "speed" else ("static", "kinetic")
        bare, fitting, other = (
            [column for column in others if column.heading.kind == kind and not column.heading.label]
            for kind in (MU, *kinds)
        )
        chosen = [*bare, *fitting]
        if len(bare) > 1:
            raise self._refused(bare[1], "it once", _NAME_ONE)
        if len(chosen) > 1:
            raise self._refused(chosen[0], "one column of friction", _NAME_ONE)
        if not chosen and other:
            raise self._refused(other[0], f"{kinds[0]} friction over {over}", _NAME_ONE)
        self._notes += [f"{column.heading.text!r} is {kinds[1]} friction and not used" for column in other]
        return chosen[0] if chosen else None

    def _check_repeats(self, materials: list[_Column]) -> None:
        """Note columns of one heading, which are repeats. Raises ConfigError where they are not alike."""
        by_name: dict[str, list[_Column]] = {}
        for column in materials:
            by_name.setdefault(column.heading.text, []).append(column)
        for name, alike in by_name.items():
            largest = sorted(column.largest for column in alike)
            if largest[-1] > _ALIKE * largest[0]:
                expected = "another name than the first column of this name, which holds other numbers"
                raise self._refused(alike[1], expected)
            if len(alike) > 1:
                self._notes.append(f"the {len(alike)} columns called {name!r} are repeats")

    def _friction(self, column: _Column, is_material: bool) -> Role:
        head, row = column.heading, self._known[MU]
        label = head.text if is_material else ""
        self._table.check_friction(column.position, 0.0)
        if head.is_force() or head.unit and head.kind in ("", "other") and is_column_unit(head.unit, "N"):
            return Role(column.position, row, self._newtons(column), label, 0.0)
        if head.unit in PURE or plain(head.unit) in PERCENT:
            return Role(column.position, row, "" if head.unit in PURE else "%", label)
        raise self._refused(column, "no unit", f"{MU} is a pure number, or in %")

    def _divided(self, role: Role) -> Role:
        """A column of friction forces with the load they are divided by. Raises ConfigError."""
        force = self._columns[role.position]
        load: tuple[int, str] | float
        if (i := self._table.pick("load")) is not None:
            load, shown = (i, self._newtons(self._columns[i])), repr(self._columns[i].heading.text)
        elif (above := load_above(self._table.table)) is not None:
            load, shown = above[0], f"{above[0]:g} N (line {above[1]})"
        elif self._wanted.load is not None:
            load = newtons(self._wanted.load)
            shown = f"{load:g} N (--load)"
        else:
            expected = "a friction coefficient, or a load to divide this force by"
            hint = "give the load: a column 'Load [N]', a line 'Load;15;N' above the heading, or --load '15 N'"
            raise self._refused(force, expected, hint)
        self._notes.append(f"{force.heading.text!r} is divided by {shown}")
        return role._replace(load=load)

    def _newtons(self, column: _Column) -> str:
        try:
            return column_unit(column.heading.unit, "N")
        except QuantityError as error:
            hint = error.hint if column.heading.unit else "write it in brackets: 'Force [N]'"
            raise self._refused(column, "the unit of a force", hint) from None

    # --- standard deviations, materials -------------------------------------------------------------------------------

    def _deviations(self, frictions: list[Role]) -> list[Role]:
        """The columns of standard deviations that belong to one of friction. Raises ConfigError."""
        sigmas = [column for column in self._columns if column.heading.kind == SIGMA and column.has_numbers]
        bare = [column for column in sigmas if not column.heading.label]
        if len(frictions) == 1 and not frictions[0].label and len(bare) > 1:
            raise self._refused(bare[1], "it once", "remove one of the two")
        deviations = []
        for role in frictions:
            own = bare if not role.label else [column for column in sigmas if self._belongs(column, role)]
            if len(own) != 1 or role.load is not None:
                continue
            i, unit = own[0].position, own[0].heading.unit
            unit = "%" if plain(unit) in PERCENT else unit
            is_pure = unit in PURE and not role.unit or unit == role.unit
            beside = (row for row in self._rows if _is_there(row, role.position))
            if is_pure and (not role.label or all(i < len(row) and _size(row[i].text) > 0 for row in beside)):
                deviations.append(Role(i, self._known[SIGMA], role.unit, role.label))
                if role.label:
                    self._notes.append(f"{own[0].heading.text!r} is the standard deviation of {role.label!r}")
        return deviations

    def _belongs(self, sigma: _Column, role: Role) -> bool:
        """True for a column of standard deviations that is called after one of friction."""
        label, head = plain(sigma.heading.label), self._columns[role.position].heading
        names = (head.name, head.text, head.label, heading(head.name).label)
        return bool(label) and label in map(plain, names)

    def _group(self) -> int | None:
        heads = ((column, column.heading) for column in self._columns)
        columns = [column for column, head in heads if head.kind == "material" and not head.unit and head.text]
        named = [column for column in columns if not column.is_numbers]
        group = named or [column for column in columns if column.is_count and len({*column.texts}) < len(column.texts)]
        return group[0].position if len(group) == 1 else None

    # --- what is wrong ------------------------------------------------------------------------------------------------

    def _called(self, word: str) -> _Column:
        called = [column for column in self._columns if column.heading.is_called(word)]
        if len(called) == 1:
            return called[0]
        names = listed([repr(column.heading.text) for column in self._columns])
        count = f"{len(called)} columns are" if called else "no column is"
        raise self._table.error(f"{count} called {word!r}, expected {names}")

    def _refused(self, column: _Column, expected: str, hint: str | None = None) -> ConfigError:
        return self._table.refused(column.position, expected, hint)

    def _lacking(self, missing: list[Parameter], others: Iterable[_Column]) -> ConfigError:
        """An error about columns that are not there, with the heading that was perhaps meant."""
        heads = ((column, column.heading) for column in others)
        others = [column for column, head in heads if head.text and (head.label or head.kind not in self._known)]
        for column in others:
            if near := nearest(column.heading.name, self._known):
                expected = f"{listed([*self._known])}, with the unit in brackets"
                return self._refused(column, expected, f"did you mean {near!r}?")
        lacking = listed([f"{column.name} ({column.long_name})" for column in missing], "and")
        if not others or is_number(others[0].heading.text):
            hint = f"the first line names the columns, for instance '{example([*self._known.values()])}'"
            return self._table.error(f"no column is called {lacking}", hint)
        unknown = listed([repr(column.heading.text) for column in others], "and")
        likely = [column.heading.text for column in others if is_column_unit(column.heading.unit, missing[0].units)]
        word = likely[0] if len(likely) == 1 else "HEADING"
        options = ["--friction-column 'HEADING'" if c.name == MU else f"--{c.name}-column '{word}'" for c in missing]
        hint = f"columns of other names are taken by {listed(options, 'and')}"
        return self._table.error(f"no column is called {lacking}; not understood: {unknown}", hint)


def _is_there(row: tuple[Cell, ...], i: int) -> bool:
    return i < len(row) and row[i].text.lower() not in GAPS


def _size(text: str) -> float:
    """A number, 0 where a text is none; read exactly later."""
    text = text.replace(",", ".")
    return float(text) if NUMBER.fullmatch(text) else 0.0
