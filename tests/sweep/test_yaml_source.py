"""Files that are no configuration at all, or unusual ones that are: what load_config says of them."""

import re

import pytest

from helpers.data import cases, rows
from stickslip.config.reader import load_config, parse_config
from stickslip.config.yaml import parse_yaml
from stickslip.errors import ConfigError

GOOD = """\
system: {mass: 1 kg, stiffness: 10, normal_load: 5 N, belt_speed: 10 mm/s}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
"""


def file_message(path) -> str:
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    return str(caught.value).replace(str(path.parent), "DIR")


REFUSED = rows("refused_files.yaml")


@pytest.mark.parametrize("row", REFUSED, ids=[row["wrong"] for row in REFUSED])
def test_what_is_no_configuration_at_all_is_explained(tmp_path, row):
    (tmp_path / "map.yaml").write_bytes(row["file"].encode("latin-1"))
    assert re.fullmatch(".*".join(map(re.escape, row["said"].split("…"))), file_message(tmp_path / "map.yaml"))


def test_a_missing_file_is_named(tmp_path):
    hint = "`stickslip init --list` names those that come with stickslip"
    assert file_message(tmp_path / "map.yaml") == f"DIR/map.yaml: no such file\n  hint: {hint}"


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


@cases("sweep.yaml")
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
