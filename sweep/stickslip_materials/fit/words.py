"""The table of words by which headings are understood: names of quantities in three languages, and their company."""

import math
import re
import unicodedata
from functools import lru_cache

# By kind of column its SI units, and its words: what follows a bar may be cut short; parts of a word joined by a plus
# sign may stand apart.
KINDS = {
    "speed": ("m s-1", "speed, spd, vel|ocity, v, w, v rel, v gleit, v slip, v sliding, slid|ing speed, "
        "slid|ing vel|ocity, slip speed, slip vel|ocity, rel|ative speed, rel|ative vel|ocity, drive speed, "
        "drive vel|ocity, geschw|indigkeit, gl|eit+geschw|indigkeit, rel|ativ+geschw|indigkeit, vit|esse, "
        "vit|esse de gliss|ement, vit|esse gliss|ement, vit|esse rel|ative"),
    "time": ("s", "time, timestamp, t, waiting time, wait, hold time, dwell time, dwell, contact time, elapsed time, "
        "zeit, wartezeit, haltezeit, kontaktzeit, messzeit, prüfzeit, versuchszeit, temps, durée, temps de contact, "
        "temps d'attente"),
    "mu": ("", "mu, mue, μ, cof, daq cof, friction, fric|tion coef|ficient, coef|ficient of fric|tion, traction, "
        "traction coef|ficient, coef|ficient of traction, reibung, reib|ungs+wert, reib|ungs+beiwert, "
        "reib|ungs+z|ahl, reib|ungs+koef|fizient, frottement, coef|ficient de frot|tement, coef|ficient frot|tement"),
    "friction_force": ("N", "fric|tion force, frictional force, force of fric|tion, f friction, f r, f f, f t, f reib, "
        "reib|ungs+kr|aft, tang|ential force, tang|ential+kr|aft, traction force, force de frot|tement, "
        "force tangentielle"),
    "load": ("N", "load, norm|al load, norm|al force, applied load, test load, f n, last, norm|al+kr|aft, "
        "norm|al+last, auflast, prüfl|ast, pruefl|ast, prüfkr|aft, pruefkr|aft, belast|ung, anpresskr|aft, "
        "andruckkr|aft, charge, force norm|ale, charge norm|ale, effort norm|al"),
    "force": ("N", "f, force, kraft, spring force, federkraft, messkraft, horizontal force, effort"),
    "acceleration": ("m s-2", "acceleration, accel, acc, a, beschl|eunigung, accélération"),
    "displacement": ("m", "displacement, drive displacement, drive position, position, weg, verschiebung, déplacement"),
    "stick": ("", "stick"),
    "rotation": ("s-1", "rotation, rotational speed, rotation speed, speed of rotation, rotary speed, spindle speed, "
        "rpm, upm, drehz|ahl, umdrehungen, drehgeschw|indigkeit, vitesse de rotation"),
    "radius": ("m", "radius, track radius, wear track radius, friction radius, sliding radius, reib|ungs+radius, "
        "lauf+radius, spur+radius, laufbahn+radius, bahn+radius, rayon, rayon de piste, rayon de frottement"),
    "begin": ("s", "begin, start, from, beginn, von"),
    "end": ("s", "end, stop, to, ende, bis"),
    "sigma": ("", "sigma, σ"),
    "direction": ("", "direction, dir, up/down, up down, ramp, ramp direction, branch, sweep, sweep direction, "
        "richtung, hin/her, hin her, auf/ab, rampe, ast, sens"),
    "material": ("", "material, lubricant, sample, specimen, grease, oil, werkstoff, paarung, schmierstoff, "
        "schmierfett, probe, muster, matériau, lubrifiant, graisse, échantillon, éprouvette"),
}  # fmt: skip
PHYSICAL = {kind: unit for kind, (unit, _) in KINDS.items() if unit}
POINTS = (  # kinds in tables of points
    "speed", "time", "mu", "friction_force", "load", "rotation", "sigma", "direction", "material",
)  # fmt: skip
STEPS = (  # kinds in records in steps
    "time", "speed", "mu", "friction_force", "force", "load", "rotation", "displacement", "sigma",
)  # fmt: skip
PLAN = ("begin", "end", "speed", "rotation", "load")  # in tables of when they begin and end
RECORD = ("time", "force", "friction_force", "acceleration", "speed", "displacement", "stick", "mu", "load")  # of a rig
TURNS = {  # rad/s of one; people mean turns by 1/min and Hz
    **dict.fromkeys("rpm upm u/min 1/min /min min-1 min^-1 rev/min r/min tr/min".split(), math.pi / 30),
    **dict.fromkeys("hz 1/s s-1 s^-1 rev/s u/s rps tr/s".split(), 2 * math.pi), "rad/s": 1.0,
}  # fmt: skip
LONG_SPEED = re.compile(  # Motor speed
    r"(.*(?:speed|velocity|(?<![^\W_])vel|geschw[^\W_]*|vitesse)(?![^\W_])[.)]?)(.*)", re.IGNORECASE
)
NOT_OF_SLIDING = re.compile(  # speeds of rotation, rolling, wear, vibration, of one of two bodies: which, nobody knows
    r"umfang|circumf|periph|(?<!t)roll|roul|walz|entrain|summe|dreh|winkel|rotat|angul|wear|usure|verschlei|abras"
    r"|abtrag|abtast|vibr|schwing|sound|schall"
)
UNIT_BEHIND = re.compile(r"(.+?)(?:(?:\s+in\s+|\s*,\s*|\s+/\s+|\s+(?=\S+/))([^,]+)|[\s_]*(%))")
END = re.compile(r"[\s,_:/]*(?:\bin)?[\s,_:/]*$")  # between a name and its unit
QUALIFIERS = frozenset(
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


MANNERS = {  # of friction, beside its words
    "static": frozenset(map(plain, "static stat s haft statisch statische statique h 0".split())),
    "kinetic": frozenset(map(plain, "kinetic dynamic kin dyn k d g gleit sliding dynamisch dynamische kinetisch "
                                    "kinetische dynamique cinétique".split())),
}  # fmt: skip
GLUED = re.compile(r"\b(haft|gleit|mu|μ)(?=\w)")  # Gleitreibung, mus
SIGMA = re.compile(
    r"\b(?:std ?dev(?:iation)?|st ?dev|std ?abw(?:eichung)?|stabw|standard ?(?:dev\w*|abw\w*|error|fehler)|sdev"
    r"|std|sd|sem?|ecart type|erreur (?:type|standard)|sigma|σ)(?!\w)|\b(?:s|sd|std|σ|sigma) ?\( ?(?=[\w ]+\))"
    r"|^s (?=(?:mu|μ|cof)$)"
)
SPREAD = frozenset(
    "± err error errors fehler unsicherheit messunsicherheit uncertainty incertitude var variance varianz cv "
    "rsd ci ki min max minimum maximum lower upper untere obere peak range spannweite streuung scatter dev "
    "deviation abweichung".split()
)
BOUND = re.compile(r"(?:ci|ki|u|k) ?\d+|[123] ?(?:s|sd|σ|sigma)")  # u95, 2s
COMPUTED = re.compile(  # what is no longer the quantity itself: log v, 1/mu, mu x100, mu/mu0
    r"^\s*(?:-|1\s*/|(?:log|lg|ln|log10|sqrt)\b|[√Δ])|[x×*]\s*1\d|\*|\w\s*/\s*(?:mu|[µμ])"
    r"|\s[-+]\s*\d*[.,]\d|\^",
    re.IGNORECASE,
)
SET = frozenset(
    "set setpoint sp nominal nom target consigne cmd command commanded demand vorgabe ref reference".split()
)
WAITING = re.compile(r"wait|hold|dwell|contact|rest|stationary|wart|halt|kontakt|stand|ruhe|attente|repos|age?ing")
NUMBERED = frozenset("no nr n° # id name number nummer nom numéro numero code".split())  # sample no.
OTHER = frozenset(  # quantities that are no friction coefficient, whatever stands beside them
    plain(word)
    for word in "temp température t° rh cycle cycles zyklus zyklen stroke strokes hub no nr n° # anzahl index point "
    "points punkt step line row zeile date datum uhrzeit comment kommentar remark remarks bemerkung operator bediener "
    "ratio srr wear usure couple last charge fx fy fz ft r2 count id channel kanal ecr effort work heat radius rayon "
    "travail chaleur travel stress film length width depth area path track lap laps nm ncm mnm kw mw mj kj mpa gpa kpa "
    "bar mv kv loss angle winkel duration durée index humidité fréquence tension courant".split()
)
OTHER_ENDS = tuple(  # of words, which German and instruments join
    plain(word)
    for word in "temperatur temperature feuchte feuchtigkeit humidity moment torque kraft force druck pressure "
    "pression nummer number geschwindigkeit speed velocity vitesse verschleiß beschleunigung acceleration "
    "strecke distance position zeit time viskosität viscosity frequenz frequency drehzahl zähler counter "
    "weg leistung power puissance energie energy énergie arbeit wärme radius durchmesser diameter "
    "diamètre dauer spannung voltage strom current widerstand resistance load spur".split()
)
# No word for a force.
COEFFICIENT = re.compile(r"c$|coe|cof|mu\w{0,3}$|μ|.*(?:koe|zahl|(?<!mittel)wert)|reib\w*[wz]$")
FRICTION_OF = re.compile(r"(?:anti |non )?(?:fric|slid|slip|reib|gleit|haft|frott|gliss|tract|adher)")
LUBRICANTS = re.compile(r"lack|fett|o[el]l?$|paste|wachs|spray|coating|schicht|additi")
PURE = ("", "1", "-", "–", "—")  # how people write "no unit"
PERCENT = ("%", "percent", "prozent", "pct", "pour cent", "v h")
GROUP = re.compile(r"\s*/?\s*(?:\[([^\[\]]*)\]|(?<!\^)\(((?:[^()]|\^\([^()]*\))*)\))")
