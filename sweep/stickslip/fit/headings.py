"""Headings of tables in parts: kind of column, unit and label, by words of people and instruments in three languages.

A heading is a name with the unit in brackets (`v [mm/s]`, `v / (mm/s)`) or behind it (`v in mm/s`, `Speed, mm s-1`).
Names are compared without regard to case, accents, points, hyphens and underscores. One table of words serves measured
points and records of a rig, and says how far each word may be cut short (`Gleitgeschw.`, `Reib.-Zahl`). What stands
behind the name of a physical quantity and is no known qualifier (`set`, `soll`) is taken for its unit, so that a unit
nobody understands is refused rather than left out.
"""

import re
import unicodedata
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

from stickslip.errors import QuantityError
from stickslip.files.tables import NUMBER, Table, first_cells
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import is_column_unit

# By kind of column its SI units, and its words: what follows a bar may be cut short; parts of a word joined by a plus
# sign may stand apart.
_KINDS = {
    "speed": ("m s-1", "speed, spd, vel|ocity, v, w, v rel, v gleit, v slip, v sliding, slid|ing speed, "
        "slid|ing vel|ocity, slip speed, slip vel|ocity, rel|ative speed, rel|ative vel|ocity, drive speed, "
        "drive vel|ocity, geschw|indigkeit, gl|eit+geschw|indigkeit, rel|ativ+geschw|indigkeit, vit|esse, "
        "vit|esse de gliss|ement, vit|esse gliss|ement, vit|esse rel|ative"),
    "time": ("s", "time, t, waiting time, wait, hold time, dwell time, dwell, contact time, elapsed time, zeit, "
        "wartezeit, haltezeit, kontaktzeit, messzeit, prüfzeit, versuchszeit, temps, durée, temps de contact, "
        "temps d'attente"),
    "mu": ("", "mu, mue, μ, cof, friction, fric|tion coef|ficient, coef|ficient of fric|tion, traction, "
        "traction coef|ficient, coef|ficient of traction, reibung, reib|ungs+wert, reib|ungs+beiwert, "
        "reib|ungs+z|ahl, reib|ungs+koef|fizient, frottement, coef|ficient de frot|tement, coef|ficient frot|tement"),
    "friction_force": ("N", "fric|tion force, frictional force, force of fric|tion, f friction, f r, f reib, "
        "reib|ungs+kr|aft, tang|ential force, tang|ential+kr|aft, traction force, force de frot|tement, "
        "force tangentielle"),
    "load": ("N", "load, norm|al load, norm|al force, applied load, test load, f n, last, norm|al+kr|aft, "
        "norm|al+last, auflast, prüfl|ast, pruefl|ast, prüfkr|aft, pruefkr|aft, belast|ung, anpresskr|aft, "
        "andruckkr|aft, charge, force norm|ale, charge norm|ale, effort norm|al"),
    "force": ("N", "f, force, kraft, spring force, federkraft, messkraft, horizontal force, effort"),
    "acceleration": ("m s-2", "acceleration, accel, acc, a, beschl|eunigung, accélération"),
    "displacement": ("m", "displacement, drive displacement, drive position, position, weg, verschiebung, déplacement"),
    "stick": ("", "stick"),
    "sigma": ("", "sigma, σ"),
    "direction": ("", "direction, dir, up/down, up down, ramp, ramp direction, branch, sweep, sweep direction, "
        "richtung, hin/her, hin her, auf/ab, rampe, ast, sens"),
    "material": ("", "material, lubricant, sample, specimen, grease, oil, werkstoff, paarung, schmierstoff, "
        "schmierfett, probe, muster, matériau, lubrifiant, graisse, échantillon, éprouvette"),
}  # fmt: skip
_PHYSICAL = {kind: unit for kind, (unit, _) in _KINDS.items() if unit}
POINTS = (
    "speed",
    "time",
    "mu",
    "friction_force",
    "load",
    "sigma",
    "direction",
    "material",
)  # kinds in tables of points
RECORD = ("time", "force", "friction_force", "acceleration", "speed", "displacement", "stick", "mu", "load")  # of a rig
_FORCE_TOO = frozenset(("friction", "reibung", "frottement", "traction"))  # words for the coefficient and the force
_LONG_SPEED = re.compile(  # Motor speed
    r"(.*(?:speed|velocity|(?<![^\W_])vel|geschw[^\W_]*|vitesse)(?![^\W_])[.)]?)(.*)", re.IGNORECASE
)
_NOT_OF_SLIDING = re.compile(  # speeds of rotation, rolling, wear, vibration, of one of two bodies: which, nobody knows
    r"umfang|circumf|periph|(?<!t)roll|roul|walz|entrain|summe|dreh|winkel|rotat|angul|wear|usure|verschlei|abras"
    r"|abtrag|abtast|vibr|schwing|sound|schall"
)
_UNIT_BEHIND = re.compile(r"(.+?)(?:(?:\s+in\s+|\s*,\s*|\s+/\s+)([^,]+)|[\s_]*(%))")
_END = re.compile(r"[\s,_:/]*(?:\bin)?[\s,_:/]*$")  # between a name and its unit
_QUALIFIERS = frozenset(
    "mean avg average mittel mittelw mittelwert mittl mittlere mittlerer durchschn durchschnittl mw median "
    "moyen moyenne moy ø value wert valeur "
    "measured gemessen set setpoint soll sollwert nominal nom target consigne ist istwert actual act real rel "
    "relative in en the of der des von".split()
)


@lru_cache(maxsize=4096)
def plain(word: str) -> str:
    """A name as it is compared."""
    bare = "".join(c for c in unicodedata.normalize("NFKD", word.casefold()) if not unicodedata.combining(c))
    return " ".join(re.sub(r"[_\-.':’]", " ", bare).split())


_STATIC = frozenset(map(plain, "static stat s haft statisch statische statique h 0".split()))
_KINETIC = frozenset(
    plain(word)
    for word in "kinetic dynamic kin dyn k d g gleit sliding dynamisch dynamische kinetisch kinetische dynamique "
    "cinétique".split()
)
_SIGMA = re.compile(
    r"\b(?:std ?dev(?:iation)?|st ?dev|std ?abw(?:eichung)?|stabw|standard ?(?:dev\w*|abw\w*|error|fehler)|sdev"
    r"|std|sd|sem?|ecart type|erreur (?:type|standard)|sigma|σ)(?!\w)|\b(?:s|sd|std|σ|sigma) ?\( ?(?=[\w ]+\))"
    r"|^s (?=(?:mu|μ|cof)$)"
)
_SPREAD = frozenset(
    "± err error errors fehler unsicherheit messunsicherheit uncertainty incertitude var variance varianz cv "
    "rsd ci ki min max minimum maximum lower upper untere obere peak range spannweite streuung scatter dev "
    "deviation abweichung".split()
)
_BOUND = re.compile(r"(?:ci|ki|u|k) ?\d+|[123] ?(?:s|sd|σ|sigma)")  # u95, 2s
_COMPUTED = re.compile(  # what is no longer the quantity itself: log v, 1/mu, mu x100, mu/mu0
    r"^\s*(?:-|1\s*/|(?:log|lg|ln|log10|sqrt)\b|[√Δ])|[x×*]\s*1\d|\*|\w\s*/\s*(?:mu|[µμ])"
    r"|\s[-+]\s*\d*[.,]\d|\^",
    re.IGNORECASE,
)
_NUMBERED = frozenset("no nr n° # id name number nummer nom numéro numero code".split())  # sample no.
_OTHER = frozenset(
    plain(word)
    for word in "temp temperature temperatur température t° pressure humidity humidite rh cycle cycles zyklus zyklen "
    "stroke strokes hub distance position number no nr n° # anzahl index point points punkt step line row zeile date "
    "datum uhrzeit comment kommentar remark remarks bemerkung operator bediener ratio srr viscosity wear usure "
    "torque couple moment acceleration load last force kraft charge speed time zeit fx fy fz ft r2 count id "
    "channel kanal ecr resistance voltage effort".split()
)
_OTHER_ENDS = (
    "temperatur", "feuchte", "feuchtigkeit", "moment", "kraft", "druck", "nummer", "geschwindigkeit", "verschleiss",
    "beschleunigung", "strecke", "zeit", "viskositat", "frequenz", "drehzahl", "zahler", "weg",
)  # fmt: skip
PURE = ("", "1", "-", "–", "—")  # how people write "no unit"
PERCENT = ("%", "percent", "prozent", "pct", "pour cent", "v h")
_GROUP = re.compile(r"\s*/?\s*(?:\[([^\[\]]*)\]|(?<!\^)\(((?:[^()]|\^\([^()]*\))*)\))")


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

    def is_called(self, word: str) -> bool:
        """True for a word that is all of the heading, or its name."""
        return plain(word) in (plain(self.text), plain(self.name))

    def may_be_force(self) -> bool:
        """True where the word for this friction is also that for the force."""
        return self.kind == "friction_force" or self.kind == "mu" and bool(_FORCE_TOO & set(_tokens(self.name)))

    def is_force(self) -> bool:
        """True for friction as a force: called so, or friction with a unit of force."""
        return self.kind == "friction_force" or self.may_be_force() and is_column_unit(self.unit, "N")


@lru_cache(maxsize=4096)
def heading(text: str, kinds: tuple[str, ...] = POINTS, names: tuple[str, ...] = ()) -> Heading:
    """A heading in parts.

    kinds : of columns there may be. names : further names of columns, which are kinds of their own.
    """
    parts = _heading(text, kinds, names)
    return replace(parts, kind="other") if _COMPUTED.search(parts.name) and parts.kind not in names else parts


def _heading(text: str, kinds: tuple[str, ...], names: tuple[str, ...]) -> Heading:
    shown = text.translate(units.AS_TYPED)
    name, unit = _cut(shown)
    if own := next((n for n in names if plain(n) in (plain(shown), plain(name))), ""):
        return Heading(text, name, unit, own)
    kind, rest = _known(name, kinds)
    if name == "T" and not is_column_unit(unit, "s"):
        return Heading(text, name, unit, "other")  # a temperature
    if "sigma" in kinds and kind not in _PHYSICAL and (deviation := _deviation(name)):
        known, rest = _known(deviation[1], kinds)
        return Heading(text, name, unit, deviation[0], rest if known in ("mu", "kinetic") else deviation[1])
    if kind in ("material", "direction") and not set(_tokens(rest)) <= _NUMBERED:
        kind, rest = "", ""  # grease A, ramp 2
    if not kind and "speed" in kinds and (longer := _LONG_SPEED.fullmatch(name)):
        if _NOT_OF_SLIDING.search(plain(longer[1])):
            return Heading(text, name, unit, "other")
        behind = _rest(longer[2], "speed", kinds)
        if not behind or not unit and is_column_unit(behind):
            return Heading(text, longer[1], unit or behind, "speed", longer[1])
    if rest and not unit and (kind in _PHYSICAL or plain(rest) in PERCENT or is_column_unit(rest)):
        return Heading(text, _END.sub("", name[: -len(rest)]), rest, kind)
    if not kind and "mu" in kinds and any(word in _OTHER or word.endswith(_OTHER_ENDS) for word in _tokens(name)):
        kind = "other"
    if not kind and not unit and (bare := _UNIT_BEHIND.fullmatch(name)):
        word = bare[2] or bare[3]
        if plain(word) in PERCENT or word.startswith("°") or is_column_unit(word):
            return Heading(text, bare[1], word)
    return Heading(text, name, unit, kind, rest)


def trailing_unit(text: str, of: str) -> str:
    """The unit in these SI units that stands behind a name nobody knows, without brackets; nothing if none does."""
    words = text.translate(units.AS_TYPED).replace(",", " ").split()
    ends = (" ".join(words[i:]).removeprefix("in ") for i in range(1, len(words)))
    return next((end for end in ends if is_column_unit(end, of)), "")


def words_for(kinds: Collection[str]) -> list[str]:
    """Every name of some kinds of columns, in full."""
    words = (word for kind in kinds for word in (kind, *_KINDS.get(kind, ("", ""))[1].split(", ")) if word)
    return [word.replace("|", "").replace("+", "") for word in words]


def with_units_below(
    table: Table, headings: list[Heading], kinds: tuple[str, ...] = POINTS
) -> tuple[list[Heading], bool]:
    """The headings with the units of a line of their own below them, and whether there is one.

    kinds : of columns there may be. Such a line holds no number, and the unit of a column whose heading has none; other
    words in it belong to the headings.
    """
    texts = [cell.text.strip("[]() ") for cell in first_cells(table)]
    if len(texts) != len(headings) or len(table.lines) < 2 or any(NUMBER.fullmatch(t.replace(",", ".")) for t in texts):
        return headings, False
    pairs = [*zip(headings, texts, strict=True)]
    if not any(not h.unit and is_column_unit(text, _PHYSICAL[h.kind]) for h, text in pairs if h.kind in _PHYSICAL):
        return headings, False
    return [above if not below or above.unit else _continued(above, below, kinds) for above, below in pairs], True


def _continued(above: Heading, below: str, kinds: tuple[str, ...]) -> Heading:
    """A heading that goes on in the line below: with a unit, or with words such as `std`."""
    is_unit = _is_unit(below)
    text = f"{above.text} [{below}]" if is_unit or above.kind in _PHYSICAL else f"{above.text} {below}"
    joined = heading(text, kinds)
    return replace(joined, text=above.text if is_unit else joined.text, kind=joined.kind or above.kind)


def _cut(text: str) -> tuple[str, str]:
    """Name and unit of a heading: what stands in the last brackets that hold a unit, else in the last square ones."""
    groups = [(m, (m[1] if m[1] is not None else m[2]).strip(), m[1] is None) for m in _GROUP.finditer(text)]
    with_unit = [(m, inner) for m, inner, is_round in groups if _is_unit(inner, is_round)]
    square = [(m, inner) for m, inner, is_round in groups if not is_round and plain(inner) not in _QUALIFIERS]
    if not (with_unit or square):
        return text.strip(), ""
    match, unit = (with_unit or square)[-1]
    return f"{_END.sub('', text[: match.start()])} {text[match.end() :]}".strip(), unit or "-"


@lru_cache(maxsize=4096)
def _is_unit(text: str, in_round: bool = False) -> bool:
    """True for a unit of something; a capital letter in round brackets rather names a material."""
    if text in PURE or plain(text) in PERCENT or is_column_unit(text):
        return True
    if plain(text) in _QUALIFIERS or _joined(text) in _index()["mu"] or in_round and re.fullmatch("[A-Z]", text):
        return False
    try:
        units.si_value(f"1 {text}", "m s-1")
    except QuantityError as error:
        return error.found is not None or bool(error.hint and error.hint.startswith("did you mean"))
    return True


def _deviation(name: str) -> tuple[str, str] | None:
    """`sigma` for a column of standard deviations, `spread` for other errors and extremes; what they belong to."""
    if re.search(r"±|\+\s*/?\s*-", name):
        return "spread", re.sub(r"±|\+\s*/?\s*-", " ", name).strip()
    if (match := _SIGMA.search(plain(name))) is not None:
        base = plain(name)[: match.start()] + plain(name)[match.end() :]
        return "sigma", " ".join(base.strip(" ()").removeprefix("of ").split())
    words = _tokens(name)
    is_bound = any(map(_BOUND.fullmatch, words)) or re.match(r"(u|d|delta|δ) ?(\(|mu$|μ$)", plain(name))
    if is_bound or _SPREAD & set(words):
        return "spread", " ".join(w for w in words if w not in _SPREAD)
    return None


def _known(name: str, kinds: tuple[str, ...]) -> tuple[str, str]:
    """The kind of a column whose name begins with a word of the table, and the rest of it without qualifiers."""
    start = re.match(rf"(?:(?:{'|'.join(sorted(_QUALIFIERS))})\b\.?[\s_]*)*", name, re.IGNORECASE)
    body = name[start.end() :] if start and start.end() < len(name) else name
    ends = [len(body), *(m.start() for m in reversed([*re.finditer(r"[\s,_:/(\[\-]", body)]))]
    for end in ends:
        if kind := _kind_of(plain(body[:end]), kinds):
            rest = _rest(body[end:], kind, kinds)
            is_letter = len(plain(body[:end])) == 1 and kind in _PHYSICAL  # W-40 is no speed
            if not (is_letter and rest) or re.match(r"[\[(]|.*[/^]", rest) or is_column_unit(rest):
                return kind, rest
    return "", ""


def _kind_of(word: str, kinds: tuple[str, ...]) -> str:
    joined, index = _joined(word), _index()
    if (exact := next((kind for kind in kinds if joined in index[kind]), "")) or not word or "mu" not in kinds:
        return exact
    parts = word.split()
    for kind, words in (("static", _STATIC), ("kinetic", _KINETIC)):
        if word in words and len(word) > 3:
            return kind
        for i, part in enumerate(parts):
            if part in words and "".join([*parts[:i], *parts[i + 1 :]]) in index["mu"]:
                return kind
        glued = (word.removeprefix(start) for start in ("mu", "μ") if word.startswith(start))
        if any(end in words for end in glued) or any(
            joined.startswith(w) and joined.removeprefix(w) in index["mu"] for w in ("haft", "gleit") if w in words
        ):
            return kind
    return ""


def _rest(text: str, kind: str, kinds: tuple[str, ...]) -> str:
    """The text behind a name, without qualifiers and further words for the same (`Sliding speed v`)."""
    words = text.strip(" ,/_:-").split()
    while words and (_is_spare(words[0]) or _kind_of(plain(words[0].strip("(),")), kinds) == kind):
        words = words[1:]
    while words and _is_spare(words[-1]):
        words = words[:-1]
    return " ".join(words).lstrip("/ ,:")


def _is_spare(word: str) -> bool:
    return plain(word.strip("()[],")) in {"", *_QUALIFIERS} and word not in ("/",)


def _tokens(name: str) -> list[str]:
    return [word for word in re.split(r"[\s()\[\],/]+", plain(name)) if word]


@lru_cache(maxsize=1)
def _index() -> dict[str, frozenset[str]]:
    """The words of each kind of column, cut short or not, without spaces."""
    return {
        kind: frozenset(_joined(short) for word in words.split(", ") for short in _cut_short(word))
        for kind, (_, words) in _KINDS.items()
    }


def _cut_short(word: str) -> Iterator[str]:
    """A word of the table, and all ways of writing less of it."""
    parts = [part.partition("|") for part in re.split("[ +]", word)]
    return map("".join, product(*([begin + rest[:n] for n in range(len(rest) + 1)] for begin, _, rest in parts)))


def _joined(word: str) -> str:
    """A name as it is compared, whether its parts stand apart or not."""
    return plain(word).replace(" ", "")
