"""The step between reading a document and checking it: the draws of an explanation in place of distributions."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.config.resolve import varied_paths
from stickslip.config.yaml import Document, parse_yaml
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.suggest import listed
from stickslip_explain.section import law_of

_MOST = 512  # rows, evenly chosen: more would say more than the explanation knows
_DIGITS = 9
_KEY = "explained"
_PATH = ("uncertain", _KEY)


def with_draws(document: Document) -> Document:
    """The document, with what the explanation that its section `uncertain` names has drawn.

    Its friction is that of the law of this configuration, or else of the most probable one; quantities that the
    configuration gives itself are left to it. Where draws stand beside the name (a resolved configuration), nothing
    is read. Raises ConfigError for what holds no draws.
    """
    data = document.data if isinstance(document.data, dict) else {}
    uncertain, friction = data.get("uncertain"), data.get("friction") or {}
    if not isinstance(uncertain, dict) or not isinstance(uncertain.get(_KEY), str) or not isinstance(friction, dict):
        return document
    quantities = uncertain.get("quantities") or {}
    if not isinstance(quantities, dict) or any("drawn" in row for row in quantities.values() if isinstance(row, dict)):
        return document
    file = Path(document.name).parent / uncertain[_KEY]
    law, known, rows = _draws(document, file if file.exists() else Path(uncertain[_KEY]), friction.get("law"))
    axes = data.get("axes")
    given = {str(path[-1]) for path in varied_paths(axes if isinstance(axes, dict) else {})} | {*quantities, *friction}
    given |= {name for part in data.values() if isinstance(part, dict) for name in part}
    drawn = {name: {"drawn": values} for name, values in rows.items() if name not in given}
    if not drawn:
        raise document.refused(_PATH, f"nothing is left to draw: {listed(rows, 'and')} are given here")
    friction = {name: value for name, value in known.items() if name not in given} | friction | {"law": law}
    section = {**uncertain, "quantities": {**quantities, **drawn}}
    return replace(document, data={**data, "friction": friction, "uncertain": section})


def _draws(document: Document, file: Path, law: Any) -> tuple[str, dict[str, Any], dict[str, list[float]]]:
    """The law of friction, what the explanation took as known of it, and the values of each quantity."""
    from stickslip.files.reading import open  # xarray takes its time

    with open(file) as ds:
        if "posterior_law" not in ds or "configuration" not in ds.attrs:
            raise document.refused(_PATH, f"{file} holds no draws, expected what `stickslip explain` wrote")
        names = [str(name) for name in ds["law"].values]
        likely = sorted(range(len(names)), key=lambda i: -float(ds["law_probability"][i]))
        alike = [i for i in likely if law in (None, law_of(names[i])[0])]
        if not alike:
            raise document.refused(_PATH, f"{file} explains by {listed(names)}, and the law here is {law}")
        chosen = np.flatnonzero(ds["posterior_law"].values == alike[0])
        if chosen.size < 2:
            raise document.refused(_PATH, f"{file} has no draws of {names[alike[0]]}, which explains too little")
        chosen = chosen[np.linspace(0, chosen.size - 1, min(_MOST, chosen.size)).astype(int)]
        values = {str(name): ds[f"posterior_{name}"].values[chosen] for name in ds["quantity"].values}
        own: Mapping[str, Any] = parse_yaml(str(ds.attrs["configuration"])).data
    law, fixed = law_of(names[alike[0]])
    known = {name: value for name, value in own.get("friction", {}).items() if name in QUANTITIES}
    rows = {name: [float(f"{value:.{_DIGITS}g}") for value in column] for name, column in values.items()}
    return law, known | fixed, rows
