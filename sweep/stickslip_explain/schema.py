"""What the JSON Schema says of a file of observations."""

from stickslip.config.schema import axes_schema, section_schema, strict, uncertain_schema
from stickslip.config.sections import Schema, number_schema
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip_explain.section import Explain
from stickslip_explain.settings import OF_PRIOR


def properties() -> Schema:
    """The words of a file of observations, which stand for other sections."""
    explain, uncertain = section_schema(Explain)["properties"], uncertain_schema()["properties"]
    scattered = uncertain["quantities"]["properties"]
    prior: Schema = {name: {"anyOf": [number_schema(row), *([scattered[name]] if name in scattered else [])]}
                     for name, row in QUANTITIES.items()}  # fmt: skip
    prior |= {name: uncertain[name] for name in OF_PRIOR} | {"laws": explain["laws"]}
    return {
        **{name: one for name, one in explain.items() if name != "laws"},
        "prior": strict(prior) | {"description": "what is known before: values, distributions, laws"},
        "predict": strict({"axes": axes_schema(), "draws": explain["draws"]})
        | {"description": "where to predict regimes"},
    }
