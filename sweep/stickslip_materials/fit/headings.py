"""Headings of tables in parts: kind of column, unit and label, by words of people and instruments in three languages.

A heading is a name with the unit in brackets (`v [mm/s]`, `v / (mm/s)`) or behind it (`v in mm/s`, `Speed, mm s-1`).
Names are compared without regard to case, accents, points, hyphens and underscores. One table of words serves measured
points and records of a rig, and says how far each word may be cut short (`Gleitgeschw.`, `Reib.-Zahl`). What stands
behind the name of a physical quantity and is no known qualifier (`set`, `soll`) is taken for its unit, so that a unit
nobody understands is refused rather than left out.
"""

import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import is_column_unit
from stickslip_materials.fit import words as known
from stickslip_materials.fit.words import PERCENT, POINTS, PURE, plain


@dataclass(frozen=True)
class Heading:
    """A heading in parts.

    text : all of it. name : without the unit. unit : as written, or nothing. kind : of the column, a key of the table
    of words, or `static`, `kinetic` (friction), `spread` (an error, an extreme), `other` (never friction); nothing
    where no word is known. label : what the name says besides, such as the material.
    """

    text: str
    name: str
    unit: str = ""
    kind: str = ""
    label: str = ""

    @property
    def shown(self) -> str:
        """The heading in quotation marks, with its unit where that stands below."""
        return repr(self.text) if self.unit in ("", "-") or self.unit in self.text else f"{self.text!r} in {self.unit}"

    def is_called(self, word: str) -> bool:
        """True for a word that is all of the heading, or its name."""
        return plain(word) in (plain(self.text), plain(self.name))

    def may_be_force(self) -> bool:
        """True where the word for this friction is also that for the force."""
        words = set(_tokens(self.name)) - set(_tokens(self.label))
        is_open = self.kind in ("mu", "static", "kinetic") and not any(map(known.COEFFICIENT.match, words))
        return is_open or self.kind == "friction_force"

    def has_own_unit(self) -> bool:
        """True without a unit, and with one of its kind."""
        return not self.unit or is_column_unit(self.unit, known.PHYSICAL.get(self.kind, ""))

    def is_set(self) -> bool:
        """True for what was set, of which another column may hold the actual values."""
        return any(word in known.SET or word.startswith("soll") for word in _tokens(self.text))

    def is_force(self) -> bool:
        """True for friction as a force: called so, or friction with a unit of force."""
        return self.kind == "friction_force" or self.may_be_force() and is_column_unit(self.unit, "N")


@lru_cache(maxsize=4096)
def heading(text: str, kinds: tuple[str, ...] = POINTS, names: tuple[str, ...] = ()) -> Heading:
    """A heading in parts.

    kinds : of columns there may be. names : further names of columns, which are kinds of their own.
    """
    shown = text.translate(units.AS_TYPED)
    name, unit = _cut(shown)
    if own := next((n for n in names if plain(n) in (plain(shown), plain(name))), ""):
        return Heading(text, name, unit, own)
    parts = _named(text, name, unit, kinds)
    if parts.kind in ("", "speed", "rotation", "other") and turns(parts.unit or parts.name):
        return replace(parts, kind="rotation", unit=parts.unit or parts.name)
    label = plain(parts.label.strip("()"))
    for kind, qualifiers in known.MANNERS.items():
        if parts.kind == "mu" and label in qualifiers and len(label) > 3:
            return replace(parts, kind=kind, label="")
    is_other = known.COMPUTED.search(parts.name) or "mu" in kinds and _is_other(parts)
    return replace(parts, kind="other", label="") if is_other else parts


def _named(text: str, name: str, unit: str, kinds: tuple[str, ...]) -> Heading:
    """A heading whose name begins with a word of the table, or is one of an error, or has its unit behind it."""
    kind, rest = _known(name, kinds)
    if name in ("n", "N") or name == "T" and not is_column_unit(unit, "s"):
        return Heading(text, name, unit, "other")  # a number, a temperature
    if "sigma" in kinds and kind not in known.PHYSICAL and (deviation := _deviation(name)):
        of, rest = _known(deviation[1], kinds)
        return Heading(text, name, unit, deviation[0], rest if of in ("mu", "kinetic") else deviation[1])
    if kind in ("material", "direction") and not set(_tokens(rest)) <= known.NUMBERED:
        kind, rest = "", ""  # grease A, ramp 2
    if not kind and "speed" in kinds and (longer := known.LONG_SPEED.fullmatch(name)):
        if known.NOT_OF_SLIDING.search(plain(longer[1])):
            return Heading(text, name, unit, "other")
        behind = _rest(longer[2], "speed", kinds)
        if not behind or not unit and is_column_unit(behind):
            return Heading(text, longer[1], unit or behind, "speed", longer[1])
    if rest and not unit and (kind in known.PHYSICAL or plain(rest) in PERCENT or is_column_unit(rest)):
        return Heading(text, known.END.sub("", name[: -len(rest)]), rest, kind)
    if not kind and not unit and (bare := known.UNIT_BEHIND.fullmatch(name)):
        word = bare[2] or bare[3]
        if plain(word) in PERCENT or word.startswith("°") or turns(word) or is_column_unit(word):
            return Heading(text, bare[1], word)
    return Heading(text, name, unit, kind, rest)


def _is_other(parts: Heading) -> bool:
    """True where what stands beside a word of friction makes it another quantity, or leaves it open which it is."""
    is_friction, behind = parts.kind in ("mu", "static", "kinetic"), set(_tokens(parts.label))
    words = behind if is_friction else {*_tokens(parts.name)} if parts.kind in ("", "material") else set()
    if any(word in known.OTHER or word.endswith(known.OTHER_ENDS) for word in words):
        return True
    if is_friction and parts.may_be_force():
        is_number = parts.unit in PURE or plain(parts.unit) in PERCENT or is_column_unit(parts.unit, "N")
        return bool(behind) or not is_number
    is_compound = any(map(known.FRICTION_OF.match, words)) and not is_friction
    return is_compound and not any(map(known.LUBRICANTS.search, words))


def turns(unit: str) -> float | None:
    """rad/s of a unit of rotation; None for what is none."""
    return known.TURNS.get(unit.lower().replace(" ", ""))


def words_for(kinds: Collection[str]) -> list[str]:
    """Every name of some kinds of columns, in full."""
    words = (word for kind in kinds for word in (kind, *known.KINDS.get(kind, ("", ""))[1].split(", ")) if word)
    return [word.replace("|", "").replace("+", "") for word in words]


# --- units ------------------------------------------------------------------------------------------------------------


def are_units(texts: Collection[str]) -> bool:
    """True for cells that hold units and nothing else, as a line of them below the names does."""
    bare = [text.strip("[]() ") for text in texts]
    return all(text in PURE or plain(text) in PERCENT or text.startswith("°") or turns(text) is not None
               or is_column_unit(text) for text in bare)  # fmt: skip


def below(headings: list[Heading], texts: list[str], kinds: tuple[str, ...]) -> list[Heading] | None:
    """The headings with what a line below them holds: units, and other words that belong to them; None for no such
    line, which holds the unit of a physical column whose heading has none."""
    bare = [text.strip("[]() ") for text in texts]
    if not any(not head.unit and (turns(text) or is_column_unit(text, known.PHYSICAL[head.kind]))
               for head, text in zip(headings, bare, strict=True) if head.kind in known.PHYSICAL):  # fmt: skip
        return None
    return [_continued(head, text, kinds) if text and not head.unit else head
            for head, text in zip(headings, bare, strict=True)]  # fmt: skip


def _continued(above: Heading, text: str, kinds: tuple[str, ...]) -> Heading:
    """A heading that goes on in the line below: with a unit, or with words such as `std`."""
    is_unit = _is_unit(text)
    whole = f"{above.text} [{text}]" if is_unit or above.kind in known.PHYSICAL else f"{above.text} {text}"
    both = heading(whole, kinds)
    return replace(both, text=above.text if is_unit else both.text, kind=both.kind or above.kind)


def _cut(text: str) -> tuple[str, str]:
    """Name and unit of a heading: what stands in the last brackets that hold a unit, else in the last square ones."""
    groups = [(m, (m[1] if m[1] is not None else m[2]).strip(), m[1] is None) for m in known.GROUP.finditer(text)]
    with_unit = [(m, inner) for m, inner, is_round in groups if _is_unit(inner, is_round)]
    square = [(m, inner) for m, inner, is_round in groups if not is_round and plain(inner) not in known.QUALIFIERS]
    if not (with_unit or square):
        return text.strip(), ""
    match, unit = (with_unit or square)[-1]
    return f"{known.END.sub('', text[: match.start()])} {text[match.end() :]}".strip(), unit or "-"


@lru_cache(maxsize=4096)
def _is_unit(text: str, in_round: bool = False) -> bool:
    """True for a unit of something; a capital letter in round brackets rather names a material."""
    if text in PURE or plain(text) in PERCENT or is_column_unit(text):
        return True
    if plain(text) in known.QUALIFIERS or _joined(text) in _index()["mu"] or in_round and re.fullmatch("[A-Z]", text):
        return False
    try:
        units.si_value(f"1 {text}", "m s-1")
    except QuantityError as error:
        return error.kind is not None or bool(error.hint and error.hint.startswith("did you mean"))
    return True


# --- words ------------------------------------------------------------------------------------------------------------


def _deviation(name: str) -> tuple[str, str] | None:
    """`sigma` for a column of standard deviations, `spread` for other errors and extremes; what they belong to."""
    if re.search(r"±|\+\s*/?\s*-", name):
        return "spread", re.sub(r"±|\+\s*/?\s*-", " ", name).strip()
    if (match := known.SIGMA.search(plain(name))) is not None:
        base = plain(name)[: match.start()] + plain(name)[match.end() :]
        return "sigma", " ".join(base.strip(" ()").removeprefix("of ").split())
    words = _tokens(name)
    is_bound = any(map(known.BOUND.fullmatch, words)) or re.match(r"(u|d|delta|δ) ?(\(|mu$|μ$)", plain(name))
    if is_bound or known.SPREAD & set(words):
        return "spread", " ".join(w for w in words if w not in known.SPREAD)
    return None


def _known(name: str, kinds: tuple[str, ...]) -> tuple[str, str]:
    """The kind of a column whose name begins with a word of the table, and the rest of it without qualifiers."""
    start = re.match(rf"(?:(?:{'|'.join(sorted(known.QUALIFIERS))})\b\.?[\s_]*)*", name, re.IGNORECASE)
    body = name[start.end() :] if start and start.end() < len(name) else name
    ends = [len(body), *(m.start() for m in reversed([*re.finditer(r"[\s,_:/(\[\-]", body)]))]
    for end in ends:
        if kind := _kind_of(plain(body[:end]), kinds):
            rest = _rest(body[end:], kind, kinds)
            is_letter = len(plain(body[:end])) == 1 and kind in known.PHYSICAL  # W-40 is no speed
            if not (is_letter and rest) or re.match(r"[\[(]|.*[/^]", rest) or is_column_unit(rest):
                return kind, rest
    return "", ""


def _kind_of(word: str, kinds: tuple[str, ...]) -> str:
    """The kind of column that this word is all the name of; of friction also the manner, static or kinetic."""
    index, tokens = _index(), known.GLUED.sub(r"\1 ", word).split()
    exact = next((kind for kind in kinds if _joined(word) in index[kind]), "")
    for kind, words in known.MANNERS.items() if tokens and not exact and "mu" in kinds else ():
        others = [token for token in tokens if token not in words]
        is_alone = not others and len(word) > 3 and not known.FRICTION_OF.match(word)
        if is_alone or len(others) < len(tokens) and "".join(others) in index["mu"]:
            return kind
    return exact


def _rest(text: str, kind: str, kinds: tuple[str, ...]) -> str:
    """The text behind a name, without qualifiers and further words for the same (`Sliding speed v`)."""
    words = text.strip(" ,/_:-").split()
    while words and (_is_spare(words[0]) or _kind_of(plain(words[0].strip("(),")), kinds) == kind):
        words = words[1:]
    while words and _is_spare(words[-1]):
        words = words[:-1]
    return " ".join(words).lstrip("/ ,:")


def _is_spare(word: str) -> bool:
    return plain(word.strip("()[],")) in {"", *known.QUALIFIERS} and word not in ("/",)


def _tokens(name: str) -> list[str]:
    return [word for word in re.split(r"[\s()\[\],/]+", plain(name)) if word]


@lru_cache(maxsize=1)
def _index() -> dict[str, frozenset[str]]:
    """The words of each kind of column, cut short or not, without spaces."""

    def shorter(word: str) -> list[str]:
        parts = [part.partition("|") for part in re.split("[ +]", word)]
        return ["".join(cut) for cut in product(*([a + b[:n] for n in range(len(b) + 1)] for a, _, b in parts))]

    return {kind: frozenset(_joined(short) for word in words.split(", ") for short in shorter(word))
            for kind, (_, words) in known.KINDS.items()}  # fmt: skip


def _joined(word: str) -> str:
    """A name as it is compared, whether its parts stand apart or not."""
    return plain(word).replace(" ", "")
