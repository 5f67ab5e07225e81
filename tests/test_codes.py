"""The names people read and the codes the kernels write are two lists; here they are one."""

import numpy as np
import pytest

from mutants import ROOT, mutants
from stickslip.vocabulary.models import CURVE_LAWS, LAWS, MODELS, kernel_of
from stickslip.vocabulary.quantities import MODES, REGIMES, STATUSES
from stickslip_kernels import layout
from stickslip_kernels.contacts import lugre, rate_and_state
from stickslip_kernels.contacts.stribeck import laws


@pytest.mark.parametrize("names", [REGIMES, STATUSES, MODES], ids=["regime", "status", "mode"])
def test_every_name_stands_for_the_code_the_kernels_write(names):
    assert [getattr(layout, name.upper()) for name in names] == list(range(len(names)))


def test_every_law_has_a_name_and_a_shape():
    assert set(CURVE_LAWS) == set(laws.LAWS) - {"gaussian"}  # a case of stribeck_delta
    with_memory = {*rate_and_state.LAWS, *lugre.LAWS} - {"lugre_gaussian", "lugre_table"}
    assert set(LAWS) - set(CURVE_LAWS) == {name for name in with_memory if not name.endswith("_cut_off")}


def test_kernels_of_a_law_that_numpy_holds_have_a_plain_name():
    assert repr(kernel_of(np.str_("stribeck"))) == "'stribeck'"


def test_values_with_kernels_of_their_own_name_laws_of_the_kernels():
    own = [own for model in MODELS for own in model.own_kernels.values()]
    names = {name for one in own for name in (*one.by_value.values(), one.otherwise) if name}
    assert names <= {*laws.LAWS, *lugre.LAWS, *rate_and_state.LAWS}
    assert {name for name in rate_and_state.LAWS if name.endswith("_cut_off")} <= names


@pytest.mark.parametrize(("file", "before"), [(file, before) for file, before, *_ in mutants()])
def test_a_small_error_has_a_place_to_go(file, before):
    assert (ROOT / file).read_text(encoding="utf-8").count(before) == 1
