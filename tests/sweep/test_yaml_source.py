"""Files that are no configuration at all, or unusual ones that are: what load_config says of them."""

import pytest

from stickslip.config.reader import load_config, parse_config
from stickslip.config.yaml import parse_yaml
from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import listed
from stickslip.vocabulary.results import BESIDE, STUDIES

GOOD = """\
system: {mass: 1 kg, stiffness: 10, normal_load: 5 N, belt_speed: 10 mm/s}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
"""


def file_message(path) -> str:
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    return str(caught.value).replace(str(path.parent), "DIR")


YAML = {
    "nothing": (b"", "DIR/map.yaml: the file is empty\n  hint: `stickslip init` writes a configuration to start from"),
    "only a comment": (
        b"# later\n", "DIR/map.yaml: the file is empty\n  hint: `stickslip init` writes a configuration to start from"
    ),
    "a list": (
        b"- 1\n",
        "DIR/map.yaml:1:1: got a list, expected a mapping with the keys "
        f"title, system, friction, start, axes, solver, execution, output, {listed([*STUDIES, *BESIDE])}",
    ),
    "a tab": (
        b"system:\n\tmass: 1\n",
        "DIR/map.yaml:2:1: not valid YAML: found character '\\t' that cannot start any token, "
        "while scanning for the next token\n  hint: indent with spaces, not with tabs",
    ),
    "an open bracket": (
        b"axes: [1,",
        "DIR/map.yaml:1:10: not valid YAML: expected the node content, but found 'the end of the file', "
        "while parsing a flow node",
    ),
    "a colon too many": (
        b"title: a: b\n",
        "DIR/map.yaml:1:9: not valid YAML: mapping values are not allowed here\n"
        "  hint: a text that contains ': ' needs quotes",
    ),
    "two documents": (
        b"title: a\n---\ntitle: b\n",
        "DIR/map.yaml:2:1: a second document starts here, expected one\n  hint: remove the line '---'",
    ),
    "a tag": (
        b"title: !!python/object:os.system x\n",
        "DIR/map.yaml:1:8: title: got the tag tag:yaml.org,2002:python/object:os.system, expected a plain value\n"
        "  hint: remove the tag",
    ),
    "an anchor": (
        b"title: &a [x, x]\nsystem: [*a, *a]\n",
        "DIR/map.yaml:1:8: title: got the anchor &a, expected a value\n"
        "  hint: write the value out wherever it is needed",
    ),
    "an alias": (
        b"title: *a\n",
        "DIR/map.yaml:1:8: title: got the alias *a, expected a value\n"
        "  hint: write the value out wherever it is needed",
    ),
    "a list as a key": (b"? [1]\n: 2\n", "DIR/map.yaml:1:3: got a key that is not a plain word"),
    "an abyss": (b"title: " + b"[" * 100_000, "DIR/map.yaml:1:28: title[0][0]: nested more than 20 levels deep"),
    "Latin 1": (
        b"title: \xe9t\xe9\n", "DIR/map.yaml:1:8: byte 0xe9 is not UTF-8 text\n  hint: save the file as UTF-8"
    ),
    "a result": (
        b"CDF\x01\x00",
        "DIR/map.yaml: this is a netCDF file, expected a configuration in YAML\n"
        "  hint: `stickslip inspect DIR/map.yaml` says what is in a result, `stickslip plot DIR/map.yaml` draws it",
    ),
    "bytes": (
        b"a\x01", "DIR/map.yaml:1:2: character U+0001 is not allowed in YAML\n  hint: a configuration is a text file",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", YAML)
def test_what_is_no_configuration_at_all_is_explained(tmp_path, name):
    raw, expected = YAML[name]
    path = tmp_path / "map.yaml"
    path.write_bytes(raw)
    assert file_message(path) == expected


def test_a_missing_file_is_named_with_what_lies_there(tmp_path):
    (tmp_path / "maps.yaml").write_text(GOOD)
    assert file_message(tmp_path / "map.yaml") == "DIR/map.yaml: no such file\n  hint: DIR holds maps.yaml"
    assert file_message(tmp_path / "none" / "map.yaml").endswith(
        "`stickslip init --list` names those that come with stickslip"
    )


def test_a_huge_file_is_not_read(tmp_path):
    path = tmp_path / "map.yaml"
    with path.open("wb") as file:
        file.truncate(2_000_000_000)
    assert file_message(path) == "DIR/map.yaml: larger than 1 MB, expected a configuration in YAML"


def test_a_key_that_is_a_number_is_a_problem():
    with pytest.raises(ConfigError, match="^map.yaml:3:1: got the key 1, expected a word"):
        parse_config(GOOD + "1: 2\n", "map.yaml")


def test_windows_files_with_a_byte_order_mark_are_read(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_config(path) == parse_config(GOOD)


# --- types and places -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001), ("-1E5", -1e5), (".5", 0.5), ("1.", 1.0), ("017", 17), ("0x1f", 31), ("0o17", 15), ("-3", -3),
        ("true", True), ("False", False), ("~", None), ("", None), ("-.inf", float("-inf")),
        ("yes", "yes"), ("on", "on"), ("12:30:00", "12:30:00"), ("2001-01-01", "2001-01-01"), ("1_000", "1_000"),
        ("nan", "nan"), ("1,5", "1,5"), ("'1e-3'", "1e-3"), ('"true"', "true"), ("10 mm/s", "10 mm/s"),
    ],
)  # fmt: skip
def test_words_mean_what_yaml_1_2_says(text, value):
    found = parse_yaml(f"key: {text}\n").data["key"]
    assert found == value and type(found) is type(value)


def test_every_key_and_value_has_its_place():
    document = parse_yaml("a:\n  - 1\n  - {b: 2 mm, c: [x]}\n")
    assert document.data == {"a": [1, {"b": "2 mm", "c": ["x"]}]}
    assert {key: place[:2] for key, place in document.keys.items()} == {
        ("a",): (1, 1),
        ("a", 1, "b"): (3, 6),
        ("a", 1, "c"): (3, 15),
    }
    assert {key: place[:2] for key, place in document.values.items()} == {
        (): (1, 1), ("a",): (2, 3), ("a", 0): (2, 5), ("a", 1): (3, 5),
        ("a", 1, "b"): (3, 9), ("a", 1, "c"): (3, 18), ("a", 1, "c", 0): (3, 19),
    }  # fmt: skip


def test_the_first_of_two_equal_keys_is_read_and_the_rest_of_the_file_too():
    document = parse_yaml("a: 1\na: {b: 2, b: 3}\nc: 4\n")
    assert document.data == {"a": 1, "c": 4}
    assert [(problem.path, problem.place[:2]) for problem in document.problems] == [(("a",), (2, 1))]
