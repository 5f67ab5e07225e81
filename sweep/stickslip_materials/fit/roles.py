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
from stickslip.vocabulary.column_units import column_unit, is_column_unit
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
    def largest(self) -> float:
        return max((abs(_size(text)) for text in self.texts), default=0.0)


class Search:
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
            _Column(i, one, [row[i].text for row in rows if _is_there(row, i)]) for i, one in enumerate(table.headings)
        ]
        self._notes: list[str] = []

    def roles(self) -> Roles:
        """The role of each column that is used. Raises ConfigError."""
        along = self._speed_or_time()
        others = [one for one in self._columns if along is None or one.position != along.position]
        frictions = self._frictions([one for one in others if one.heading.text], along is not None)
        if along is None or not frictions:
            lacking = [self._along] * (along is None) + [self._known[MU]] * (not frictions)
            raise self._lacking(lacking, others)
        frictions = [role if role.load is None else self._divided(role) for role in frictions]
        deviations = self._deviations(frictions) if SIGMA in self._known else []
        return Roles([along, *frictions, *deviations], self._group(), tuple(self._notes))

    # --- speed or time ------------------------------------------------------------------------------------------------

    def _speed_or_time(self) -> Role | None:
        """The column of speeds or times; None if there is none. Raises ConfigError where several may be meant."""
        name, si = self._along.name, self._along.units
        if word := self._wanted.speed if name == "speed" else self._wanted.time:
            one = self._called(word)
            text = one.heading.text
            unit = one.heading.unit or trailing_unit(text, si) or "".join(re.findall(r"[(\[].*[)\]]", text))
            return self._in_unit(one, "" if self._wanted.unit and not is_column_unit(unit, si) else unit)
        i = self._table.pick(name)
        return None if i is None else self._in_unit(self._columns[i], self._columns[i].heading.unit)

    def _in_unit(self, one: _Column, unit: str) -> Role:
        given = self._wanted.unit
        if unit and given and unit != given:
            self._notes.append(f"--unit {given} is not used, since {one.heading.text!r} has a unit")
        unit = unit or given
        try:
            return Role(one.position, self._along, column_unit(unit, self._along.units) if unit else "")
        except QuantityError as error:
            raise self._refused(one, error.expected, error.hint) from None

    # --- friction -----------------------------------------------------------------------------------------------------

    def _frictions(self, others: list[_Column], has_along: bool) -> list[Role]:
        """The columns of friction: those named, else those of friction, else all that may be. Raises ConfigError."""
        if self._wanted.friction:
            chosen = [self._called(word) for word in self._wanted.friction]
            return [self._friction(one, len(chosen) > 1 or one.heading.kind in ("", "other")) for one in chosen]
        if (single := self._unlabelled(others)) is not None:
            return [self._friction(single, False)]
        others = [one for one in others if one.has_numbers]
        kinds = (MU, "kinetic" if self._along.name == "speed" else "static")
        of_materials = [one for one in others if one.heading.kind in kinds and one.heading.label]
        forces = [one for one in others if one.heading.kind == "friction_force"]
        if not of_materials and forces:
            return [self._friction(one, len(forces) > 1) for one in forces]
        if not has_along:
            return []
        unknown = [one for one in others if one.heading.kind in ("", "material") and one.heading.unit in PURE
                   and not one.is_count and (one.is_numbers or not one.heading.kind)]  # fmt: skip
        names = [plain(one.heading.name) for one in unknown]
        spreads = {start + name for name in names for start in ("s ", "s", "u ", "u", "d ", "d", "δ", "σ")}
        unknown = [one for one, name in zip(unknown, names, strict=True) if name not in spreads]  # s_A beside A
        if of_materials:  # others beside them, which are too large, are something else
            unknown = [one for one in unknown if one.largest <= MOST_FRICTION]
        materials = sorted([*of_materials, *unknown], key=lambda one: one.position)
        self._check_repeats(materials)
        return [self._friction(one, True) for one in materials]

    def _unlabelled(self, others: list[_Column]) -> _Column | None:
        """The column of friction as such, of which a table has one. Raises ConfigError where it is not certain."""
        over = self._along.name
        kinds = ("kinetic", "static") if over == "speed" else ("static", "kinetic")
        bare, fitting, other = (
            [one for one in others if one.heading.kind == kind and not one.heading.label] for kind in (MU, *kinds)
        )
        chosen = [*bare, *fitting]
        if len(bare) > 1:
            raise self._refused(bare[1], "it once", _NAME_ONE)
        if len(chosen) > 1:
            raise self._refused(chosen[0], "one column of friction", _NAME_ONE)
        if not chosen and other:
            raise self._refused(other[0], f"{kinds[0]} friction over {over}", _NAME_ONE)
        self._notes += [f"{one.heading.text!r} is {kinds[1]} friction and not used" for one in other]
        return chosen[0] if chosen else None

    def _check_repeats(self, materials: list[_Column]) -> None:
        """Note columns of one heading, which are repeats. Raises ConfigError where they are not alike."""
        by_name: dict[str, list[_Column]] = {}
        for one in materials:
            by_name.setdefault(one.heading.text, []).append(one)
        for name, alike in by_name.items():
            largest = sorted(one.largest for one in alike)
            if largest[-1] > _ALIKE * largest[0]:
                raise self._refused(
                    alike[1], "another name than the first column of this name, which holds other numbers"
                )
            if len(alike) > 1:
                self._notes.append(f"the {len(alike)} columns called {name!r} are repeats")

    def _friction(self, one: _Column, is_material: bool) -> Role:
        head, column = one.heading, self._known[MU]
        label = head.text if is_material else ""
        self._table.check_friction(one.position, 0.0)
        if head.is_force() or head.unit and head.kind in ("", "other") and is_column_unit(head.unit, "N"):
            return Role(one.position, column, self._newtons(one), label, 0.0)
        if head.unit in PURE or plain(head.unit) in PERCENT:
            return Role(one.position, column, "" if head.unit in PURE else "%", label)
        raise self._refused(one, "no unit", f"{MU} is a pure number, or in %")

    def _divided(self, role: Role) -> Role:
        """A column of friction forces with the load they are divided by. Raises ConfigError."""
        column = self._table.pick("load")
        loads = [] if column is None else [self._columns[column]]
        force = self._columns[role.position]
        load: tuple[int, str] | float
        if len(loads) == 1:
            load, shown = (loads[0].position, self._newtons(loads[0])), repr(loads[0].heading.text)
        elif not loads and (above := load_above(self._table.table)) is not None:
            load, shown = above[0], f"{above[0]:g} N (line {above[1]})"
        elif not loads and self._wanted.load is not None:
            load = newtons(self._wanted.load)
            shown = f"{load:g} N (--load)"
        else:
            expected = "a friction coefficient, or a load to divide this force by"
            hint = "give the load: a column 'Load [N]', a line 'Load;15;N' above the heading, or --load '15 N'"
            raise self._refused(force, expected, hint)
        self._notes.append(f"{force.heading.text!r} is divided by {shown}")
        return role._replace(load=load)

    def _newtons(self, one: _Column) -> str:
        try:
            return column_unit(one.heading.unit, "N")
        except QuantityError as error:
            hint = error.hint if one.heading.unit else "write it in brackets: 'Force [N]'"
            raise self._refused(one, "the unit of a force", hint) from None

    # --- standard deviations, materials -------------------------------------------------------------------------------

    def _deviations(self, frictions: list[Role]) -> list[Role]:
        """The columns of standard deviations that belong to one of friction. Raises ConfigError."""
        sigmas = [one for one in self._columns if one.heading.kind == SIGMA and one.has_numbers]
        bare = [one for one in sigmas if not one.heading.label]
        if len(frictions) == 1 and not frictions[0].label and len(bare) > 1:
            raise self._refused(bare[1], "it once", "remove one of the two")
        deviations = []
        for role in frictions:
            own = bare if not role.label else [one for one in sigmas if self._belongs(one, role)]
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
        label, one = plain(sigma.heading.label), self._columns[role.position].heading
        return bool(label) and label in map(plain, (one.name, one.text, one.label, heading(one.name).label or one.name))

    def _group(self) -> int | None:
        columns = [one for one in self._columns
                   if one.heading.kind == "material" and not one.heading.unit and one.heading.text]  # fmt: skip
        named = [one for one in columns if not one.is_numbers]
        group = named or [one for one in columns if one.is_count and len({*one.texts}) < len(one.texts)]
        return group[0].position if len(group) == 1 else None

    # --- what is wrong ------------------------------------------------------------------------------------------------

    def _called(self, word: str) -> _Column:
        called = [one for one in self._columns if one.heading.is_called(word)]
        if len(called) == 1:
            return called[0]
        names = listed([repr(one.heading.text) for one in self._columns])
        count = f"{len(called)} columns are" if called else "no column is"
        raise self._table.error(f"{count} called {word!r}, expected {names}")

    def _refused(self, one: _Column, expected: str, hint: str | None = None) -> ConfigError:
        return self._table.refused(one.position, expected, hint)

    def _lacking(self, missing: list[Parameter], others: Iterable[_Column]) -> ConfigError:
        """An error about columns that are not there, with the heading that was perhaps meant."""
        others = [one for one in others
                  if one.heading.text and (one.heading.label or one.heading.kind not in self._known)]  # fmt: skip
        for one in others:
            if near := nearest(one.heading.name, self._known):
                expected = f"{listed([*self._known])}, with the unit in brackets"
                return self._refused(one, expected, f"did you mean {near!r}?")
        lacking = listed([f"{column.name} ({column.long_name})" for column in missing], "and")
        if not others or is_number(others[0].heading.text):
            hint = f"the first line names the columns, for instance '{example([*self._known.values()])}'"
            return self._table.error(f"no column is called {lacking}", hint)
        unknown = listed([repr(one.heading.text) for one in others], "and")
        likely = [one.heading.text for one in others if is_column_unit(one.heading.unit, missing[0].units)]
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
