"""The bytes of blocks and manifests: whole, or refused."""

import hashlib
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from stickslip.config.reader import make_config, parse_config
from stickslip.errors import DamagedBlockError, DamagedManifestError
from stickslip.files.chunks import PACKINGS
from stickslip.runs.formats import _MAGIC, Manifest, block_bytes, decoded, opened_block
from stickslip.runs.work import Work

PAIR = {"system": {"mass": 1, "stiffness": 1, "normal_load": 1}, "friction": {"a1": 1, "a2": 0, "a3": 0.1, "a4": 1}}
columns = st.dictionaries(
    st.text(min_size=1, max_size=9),
    st.sampled_from(["i1", "<i4", "<f8"]).flatmap(lambda kind: arrays.arrays(kind, st.integers(0, 20))),
    max_size=5,
)


@given(
    columns,
    st.dictionaries(st.text(max_size=5).filter(lambda k: k != "columns"), st.integers()),
    st.sampled_from(PACKINGS),
    st.integers(0, 30),
)
def test_a_block_comes_back_to_the_bit(given_columns, header, packing, length):
    found_header, found = opened_block(block_bytes(header, given_columns, packing, length))
    assert found_header == header and list(found) == list(given_columns)
    for name, values in given_columns.items():
        assert found[name].dtype == values.dtype
        assert found[name].values().tobytes() == values.tobytes()  # payloads of NaN included


@settings(max_examples=300)
@given(st.data())
def test_no_changed_bytes_pass_for_a_block(data):
    good = block_bytes({"block": 3}, {"regime": np.arange(9, dtype=np.int8), "period": np.linspace(0, 1, 9)})
    place = data.draw(st.integers(0, len(good) - 1))
    kind = data.draw(st.sampled_from(["flip", "cut", "add", "drop"]))
    bad = {
        "flip": good[:place] + bytes([good[place] ^ data.draw(st.integers(1, 255))]) + good[place + 1 :],
        "cut": good[:place],
        "add": good + b"\0",
        "drop": good[:place] + good[place + 1 :],
    }[kind]
    with pytest.raises(DamagedBlockError):
        opened_block(bad)


@given(st.binary(max_size=400))
def test_arbitrary_bytes_with_a_good_checksum_are_refused_or_read(body):
    """Whoever can write a checksum can write anything; nothing but DamagedBlockError may come of it."""
    for data in (_MAGIC + body, _MAGIC + body + b"\n"):
        try:
            header, found = opened_block(data + hashlib.sha256(data).digest())
        except DamagedBlockError as refused:
            assert str(refused)
        else:
            assert isinstance(header, dict) and isinstance(found, dict)


def manifest():
    config = make_config({**PAIR, "axes": {"belt_speed": [0.1, 0.2]}, "title": "µ"})
    return Manifest.of(Work(config))


def test_a_manifest_comes_back():
    made = manifest()
    assert decoded(made.encoded()) == made
    assert parse_config(made.configuration).title == "µ"


@given(st.data())
def test_no_changed_bytes_pass_for_a_manifest(data):
    good = manifest().encoded()
    place = data.draw(st.integers(0, len(good) - 1))
    with pytest.raises(DamagedManifestError):
        decoded(good[:place])
    flipped = good[:place] + bytes([good[place] ^ 4]) + good[place + 1 :]
    if json_of(flipped) != json_of(good):  # a changed blank changes nothing
        with pytest.raises(DamagedManifestError):
            decoded(flipped)


def json_of(data):
    try:
        return json.loads(data)
    except ValueError:
        return None
