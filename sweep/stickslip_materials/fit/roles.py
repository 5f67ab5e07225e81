"""The columns of a table of points: those that people name, those of known headings, else the materials.

Friction forces are divided by a column of loads, a line above the heading (`Prüflast;15;N`), or the load of the caller.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.errors import ConfigError, QuantityError
from stickslip.files.layout import is_number
from stickslip.files.tables import cells
from stickslip.vocabulary.display_units import column_unit, is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import listed, nearest
from stickslip_materials.fit.columns import MOST_FRICTION, HeadedTable, example, load_above, newtons
from stickslip_materials.fit.headings import heading
from stickslip_materials.fit.words import PERCENT, PURE, plain

MU, SIGMA = "mu", "sigma"
WHOLE = re.compile(r"([-+]?\d+)(?:[.,]0*)?")  # workbooks write 1.0
GAPS = ("", "nan", "na", "n/a", "-", "--", "#n/a", "#nv")  # what people write where nothing was measured
_FORCE = Parameter("friction_force", "N", "friction force", "points", at_least=0)
_LOAD = Parameter("load", "N", "normal load", "points", above=0)
_MOST_SAMPLES = 10  # of a speed that follow each other, in a table of points
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


@dataclass(frozen=True)
class Role:
    """A column that is used: its position, name of what it holds, the row of its numbers, their unit, the material.

    load : by which friction forces are divided, a column or in N.
    """

    position: int
    name: str
    row: Parameter
    unit: str = ""
    label: str = ""
    load: "Role | float | None" = None


class PointsTable:
    """A table of points: its columns, and the role of each that is used.

    columns : the one of speeds or times, that of friction, and perhaps that of its standard deviations. rows, texts :
    the cells below the heading, and the texts of complete lines; numbers : NaN where a text is none. along, frictions,
    deviations : the columns that are used; group : that which names materials; notes : on what was taken. Raises
    ConfigError where they are not there, or several may be meant.
    """

    def __init__(self, headed: HeadedTable, columns: Sequence[Parameter], wanted: Wanted) -> None:
        self.headed, self.heads, self._wanted, self.notes = headed, headed.headings, wanted, list[str]()
        self._known = {column.name: column for column in columns}
        self.rows, width = list(cells(headed.table)), len(headed.headings)
        self.complete = [row for row in self.rows if len(row) == width]
        self.texts = np.array([[cell.text for cell in row] for row in self.complete], object).reshape(-1, width)
        self.gaps = np.isin(np.char.lower(self.texts.astype(str)), GAPS)
        read = [float(text.replace(",", ".")) if is_number(text) else np.nan for text in self.texts.flat]
        self.numbers = np.array(read).reshape(self.texts.shape)
        if not wanted.speed and not wanted.time:
            self._check_record()
        along = self._along(columns[0])
        others = [i for i, head in enumerate(headed.headings) if head.text and not (along and i == along.position)]
        self.frictions = self._frictions(others, columns[0].name, along is not None)
        if along is None or not self.frictions:
            raise self._lacking([columns[0]] * (along is None) + [self._known[MU]] * (not self.frictions), others)
        self.along = along
        self.deviations = self._deviations() if SIGMA in self._known else []
        self.group = self._group()

    def _check_record(self) -> None:
        """Raises ConfigError for samples over time at steps of a speed: which are points, the steps tell."""
        speed = next(
            (i for kind in ("speed", "rotation") for i, head in enumerate(self.heads) if head.kind == kind), None
        )
        if speed is None or not any(head.kind == "time" for head in self.heads):
            return
        steps = 1 + int(np.sum(self.texts[1:, speed] != self.texts[:-1, speed]))
        if len(self.texts) >= _MOST_SAMPLES * steps:
            message = f"this is a record with {steps} steps of {self.heads[speed].text!r}, expected a point of each"
            raise self.headed.error(message, "stickslip points RECORD -o points.csv averages them")

    @property
    def roles(self) -> list[Role]:
        """Of all columns that are used."""
        return [self.along, *self.frictions, *self.deviations]

    @property
    def used(self) -> list[int]:
        """The positions of these columns, and of loads."""
        loads = [role.load.position for role in self.frictions if isinstance(role.load, Role)]
        return [role.position for role in self.roles] + loads

    def _present(self, i: int) -> list[str]:
        """The texts of a column, gaps left out."""
        return list(self.texts[~self.gaps[:, i], i])

    def _is_count(self, i: int) -> bool:
        """True for a column of whole numbers only, as no friction has."""
        return all(map(WHOLE.fullmatch, self._present(i)))

    def _are_numbers(self, i: int) -> bool:
        return all(map(is_number, self._present(i)))

    def _largest(self, i: int) -> float:
        return float(np.abs(self.numbers[:, i]).max(initial=0.0, where=~np.isnan(self.numbers[:, i])))

    # --- speed or time, friction --------------------------------------------------------------------------------------

    def _along(self, row: Parameter) -> Role | None:
        """The column of speeds or times; None if there is none."""
        word, given = self._wanted.speed if row.name == "speed" else self._wanted.time, self._wanted.unit
        if (i := self.headed.pick(row.name, word)) is None:
            return None
        head = self.heads[i]
        unit = head.unit or ("".join(re.findall(r"[(\[].*[)\]]", head.text)) if word else "")
        if word and given and not is_column_unit(unit, row.units):
            unit = ""
        if unit and given and unit != given:
            self.notes.append(f"--unit {given} is not used, since {head.text!r} has a unit")
        unit = unit or given
        try:
            return Role(i, row.name, row, column_unit(unit, row.units) if unit else "")
        except QuantityError as error:
            raise self.headed.refused(i, error.expected, error.hint) from None

    def _frictions(self, others: list[int], over: str, has_along: bool) -> list[Role]:
        """The columns of friction: those named, else the one of friction as such, else all that may be a material."""
        if self._wanted.friction:
            chosen = [self.headed.pick(MU, word) or 0 for word in self._wanted.friction]
            return [self._friction(i, len(chosen) > 1 or self.heads[i].kind in ("", "other")) for i in chosen]
        fitting, other = ("kinetic", "static") if over == "speed" else ("static", "kinetic")
        bare = [i for i in others if self.heads[i].kind in (MU, fitting) and not self.heads[i].label]
        unfit = [i for i in others if self.heads[i].kind == other and not self.heads[i].label]
        if len(bare) > 1:
            raise self.headed.refused(bare[1], "one column of friction", _NAME_ONE)
        if unfit and not bare:
            raise self.headed.refused(unfit[0], f"{fitting} friction over {over}", _NAME_ONE)
        if bare:
            self.notes += [f"{self.heads[i].text!r} is {other} friction and not used" for i in unfit]
            return [self._friction(bare[0], False)]
        others = [i for i in others if np.isfinite(self.numbers[:, i]).any()]
        named = [i for i in others if self.heads[i].kind in (MU, fitting)]
        forces = [i for i in others if self.heads[i].kind == "friction_force"]
        if forces and not named:
            return [self._friction(i, len(forces) > 1) for i in forces]
        unknown = {i: plain(self.heads[i].name) for i in others if has_along and self._may_be_material(i)}
        spreads = {start + name for name in unknown.values() for start in ("s ", "s", "u ", "u", "d ", "d", "δ", "σ")}
        materials = [i for i in others if i in named or i in unknown and unknown[i] not in spreads]  # s_A beside A
        if named:  # what is too large beside them is something else
            materials = [i for i in materials if i in named or self._largest(i) <= MOST_FRICTION]
        self._check_repeats(materials)
        return [self._friction(i, True) for i in materials if has_along]

    def _may_be_material(self, i: int) -> bool:
        """True for numbers that might be the friction of a material called so."""
        head = self.heads[i]
        is_known = head.kind not in ("", "material") or head.unit not in PURE or self._is_count(i)
        return not is_known and (not head.kind or self._are_numbers(i))

    def _check_repeats(self, materials: list[int]) -> None:
        """Note columns of one heading, which are repeats. Raises ConfigError where they are not alike."""
        by_name: dict[str, list[int]] = {}
        for i in materials:
            by_name.setdefault(self.heads[i].text, []).append(i)
        for name, alike in by_name.items():
            largest = sorted(map(self._largest, alike))
            if largest[-1] > _ALIKE * largest[0]:
                expected = "another name than the first column of this name, which holds other numbers"
                raise self.headed.refused(alike[1], expected)
            if len(alike) > 1:
                self.notes.append(f"the {len(alike)} columns called {name!r} are repeats")

    def _friction(self, i: int, is_material: bool) -> Role:
        head, label = self.heads[i], self.heads[i].text if is_material else ""
        if head.is_force() or head.unit and head.kind in ("", "other") and is_column_unit(head.unit, "N"):
            return Role(i, MU, _FORCE, self._newtons(i), label, self._load(i))
        if head.unit in PURE or plain(head.unit) in PERCENT:
            return Role(i, MU, self._known[MU], "" if head.unit in PURE else "%", label)
        raise self.headed.refused(i, "no unit", f"{MU} is a pure number, or in %")

    def _load(self, force: int) -> Role | float:
        """What a column of friction forces is divided by."""
        load: Role | float
        if (i := self.headed.pick("load")) is not None:
            load, shown = Role(i, MU, _LOAD, self._newtons(i)), repr(self.heads[i].text)
        elif (above := load_above(self.headed.table)) is not None:
            load, shown = above[0], f"{above[0]:g} N (line {above[1]})"
        elif self._wanted.load is not None:
            load = newtons(self._wanted.load)
            shown = f"{load:g} N (--load)"
        else:
            hint = "give the load: a column 'Load [N]', a line 'Load;15;N' above the heading, or --load '15 N'"
            expected = "a friction coefficient, or a load to divide this force by"
            raise self.headed.refused(force, expected, hint)
        self.notes.append(f"{self.heads[force].text!r} is divided by {shown}")
        return load

    def _newtons(self, i: int) -> str:
        unit = self.heads[i].unit
        try:
            return column_unit(unit, "N")
        except QuantityError as error:
            hint = error.hint if unit else "write it in brackets: 'Force [N]'"
            raise self.headed.refused(i, "the unit of a force", hint) from None

    # --- standard deviations, materials, what is lacking --------------------------------------------------------------

    def _deviations(self) -> list[Role]:
        """The columns of standard deviations that belong to one of friction."""
        sigmas = [i for i, head in enumerate(self.heads) if head.kind == SIGMA]
        sigmas = [i for i in sigmas if np.isfinite(self.numbers[:, i]).any()]
        bare, deviations = [i for i in sigmas if not self.heads[i].label], []
        if len(self.frictions) == 1 and not self.frictions[0].label and len(bare) > 1:
            raise self.headed.refused(bare[1], "it once", "remove one of the two")
        for role in self.frictions:
            head = self.heads[role.position]
            names = {*map(plain, (head.name, head.text, head.label, heading(head.name).label))} - {""}
            own = [i for i in sigmas if plain(self.heads[i].label) in names] if role.label else bare
            if len(own) != 1 or role.load is not None:
                continue
            sigma, values = self.heads[own[0]], self.numbers[~self.gaps[:, role.position], own[0]]
            unit = "%" if plain(sigma.unit) in PERCENT else "" if sigma.unit in PURE else sigma.unit
            if unit == role.unit and (not role.label or (values > 0).all()):
                deviations.append(replace(role, position=own[0], name=SIGMA, row=self._known[SIGMA]))
                self.notes += [f"{sigma.text!r} is the standard deviation of {role.label!r}"] if role.label else []
        return deviations

    def _group(self) -> int | None:
        """The column that tells materials apart row by row: by name, or by numbers that come again."""
        columns = [i for i, head in enumerate(self.heads) if head.kind == "material" and not head.unit and head.text]
        named = [i for i in columns if not self._are_numbers(i)]
        counted = [i for i in columns if self._is_count(i) and len({*self._present(i)}) < len(self._present(i))]
        group = named or counted
        return group[0] if len(group) == 1 else None

    def _lacking(self, missing: list[Parameter], others: list[int]) -> ConfigError:
        """An error about columns that are not there, with the heading that was perhaps meant."""
        heads = {i: head for i in others if (head := self.heads[i]).label or head.kind not in self._known}
        for i, head in heads.items():
            if near := nearest(head.name, self._known):
                return self.headed.refused(i, f"{listed([*self._known])}, with the unit in brackets",
                                           f"did you mean {near!r}?")  # fmt: skip
        lacking = listed([f"{column.name} ({column.long_name})" for column in missing], "and")
        if not heads or is_number(next(iter(heads.values())).text):
            hint = f"the first line names the columns, for instance '{example([*self._known.values()])}'"
            return self.headed.error(f"no column is called {lacking}", hint)
        unknown = listed([repr(head.text) for head in heads.values()], "and")
        likely = [head.text for head in heads.values() if is_column_unit(head.unit, missing[0].units)]
        word = likely[0] if len(likely) == 1 else "HEADING"
        options = ["--friction-column 'HEADING'" if c.name == MU else f"--{c.name}-column '{word}'" for c in missing]
        hint = f"columns of other names are taken by {listed(options, 'and')}"
        return self.headed.error(f"no column is called {lacking}; not understood: {unknown}", hint)
