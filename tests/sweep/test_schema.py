import jsonschema
import pytest
from ruamel.yaml import YAML

from helpers.data import cases
from helpers.installed import shipped
from stickslip.config.describe import json_schema
from stickslip.config.reader import load_config, make_config
from stickslip.config.resolve import config_path, starter
from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import EXECUTION, QUANTITIES, SOLVER

SCHEMA = json_schema()


def complaints(data) -> list[str]:
    found = jsonschema.Draft202012Validator(SCHEMA).iter_errors(data)
    return ["/".join(map(str, error.absolute_path)) for error in found]


def plain(text: str):
    return YAML(typ="safe", pure=True).load(text)


@pytest.mark.parametrize("name", shipped())
def test_configurations_that_ship_are_valid(name):
    assert complaints(plain(config_path(name).read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("name", shipped())
def test_resolved_configurations_are_valid(name):
    path = config_path(name)
    text = load_config(path, apart=None).to_yaml()
    assert complaints(plain(text)) == []


def test_the_starter_is_valid():
    assert complaints(plain(starter())) == []


@cases("sweep.yaml")
def test_what_the_reader_refuses_an_editor_marks(data, where):
    assert complaints(data) == [where]


REQUIRED = {
    "border": {"along": "mass"},
    "attractors": {"displacement": [0, 1], "velocity": [0, 1]},
    "uncertain": {"quantities": {"belt_speed": {"normal": {"mean": 1, "std": 0.1}}}},
}


def beyond_bounds():
    """Section, name, and a value just beyond each bound that the vocabulary has."""
    rows = [*QUANTITIES.values(), *SOLVER.values(), *EXECUTION.values()]
    for row in rows:
        if row.above is not None:
            yield row.section, row.name, row.above
        if row.at_least is not None:
            yield row.section, row.name, row.at_least - 1
        if row.at_most is not None:
            yield row.section, row.name, 2 * row.at_most


@pytest.mark.parametrize(("section", "name", "value"), list(beyond_bounds()))
def test_every_bound_of_the_vocabulary_holds_for_the_reader_and_in_the_schema(section, name, value):
    data = {section: {**REQUIRED.get(section, {}), name: value}}
    with pytest.raises(ConfigError) as caught:
        make_config(data, apart=None)
    assert (section, name) in [problem.path for problem in caught.value.problems]
    assert complaints(data) == [f"{section}/{name}"]


def test_every_quantity_is_described_where_it_can_be_fixed_and_as_an_axis():
    for name, declared in QUANTITIES.items():
        fixed = SCHEMA["properties"][declared.section]["properties"][name]
        varied = SCHEMA["properties"]["axes"]["properties"][name]
        assert fixed["description"].startswith(declared.long_name)
        assert varied["description"] == fixed["description"]
