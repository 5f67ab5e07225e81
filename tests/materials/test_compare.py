"""Materials compared: ranks, borders and intervals against direct calls, and against points measured again."""

import json
import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from openpyxl import load_workbook

import stickslip
from helpers.commands import call
from helpers.data import cases
from helpers.measured import FILES, OPTIONS, SI, SYSTEM, law
from helpers.plotted import draws_what_the_command_draws, refuses_what_it_cannot_draw
from stickslip import progress
from stickslip.config.resolve import points_path
from stickslip.dataset import export
from stickslip.errors import ConfigError, UnitWarning
from stickslip_materials.compare.table import RankTable, material_page
from stickslip_materials.fit import CURVE_COLUMNS, draw_curves, fit_curve, fit_materials, read_materials

FALLING = "speed [mm/s], mu\n0.5, 0.14\n1, 0.132\n2, 0.124\n5, 0.115\n10, 0.11\n"
SPEED = np.array([0.5, 1, 2, 5, 10, 20, 35, 50, 75, 100, 150, 200, 300, 400]) / 1000


@pytest.fixture(scope="module")
def compared():
    return stickslip.compare(FILES, **SYSTEM, belt_speed="20 mm/s", draws=150)


def test_materials_are_ranked_by_the_border_of_their_fitted_curves(compared):
    curves = {name: compared[name].values for name in ("a1", "a2", "a3", "a4")}
    between = (compared.attrs["searched_from"], compared.attrs["searched_to"])
    found = stickslip.border({**SI, **curves}, "belt_speed", between)
    last = np.nanmax(found["border"].values, axis=1)
    np.testing.assert_allclose(compared["quiet_above"], last, rtol=3e-9)
    assert list(compared["material"].values) == ["grease_b", "grease_a", "dry"]
    assert compared["rank"].values.tolist() == [1, 2, 3] and (np.diff(last) > 0).all()
    assert (compared["quiet_state"] == 1).all()


def test_fits_files_and_curves_without_points_are_compared_together():
    dry, grease = fit_materials(FILES[:2])
    mixed = stickslip.compare([dry, FILES[1]], **SYSTEM, draws=0)
    assert sorted(mixed["material"].values) == ["dry", "grease_a"]
    bare = stickslip.compare({"dry": dry.curve, "grease_a": grease.curve}, **SYSTEM, draws=0)
    assert bare["quiet_above"].values.tolist() == mixed["quiet_above"].values.tolist()
    assert bare.sizes["point"] == 0 and "dry" in material_page(bare)


def test_just_above_the_border_it_is_quiet_and_just_below_it_is_not(compared):
    curves = {name: np.repeat(compared[name].values, 2) for name in ("a1", "a2", "a3", "a4")}
    speed = np.outer(compared["quiet_above"].values, [1 - 1e-6, 1 + 1e-6]).ravel()
    regime = stickslip.evaluate({**SI, **curves, "belt_speed": speed})["regime"].values.reshape(3, 2)
    assert (regime[:, 0] == 1).all() and np.isin(regime[:, 1], (2, 3)).all()


def test_at_a_belt_speed_margin_regime_and_probability_agree_with_the_border(compared):
    quiet = 0.02 > compared["quiet_above"].values
    np.testing.assert_allclose(compared["margin"], 0.02 / compared["quiet_above"])
    assert ((compared["regime"] == 1).values == ~quiet).all()
    assert (compared["quiet_probability"].values[~quiet] < 0.5).all()
    assert (compared["quiet_probability"].values[quiet] > 0.5).all()
    inside = compared["quiet_above"]
    assert ((compared["quiet_above_low"] < inside) & (inside < compared["quiet_above_high"])).all()


@pytest.mark.parametrize("order", [(2, 1, 0), (1, 0, 2)])
def test_the_order_of_the_files_changes_nothing(compared, order):
    again = stickslip.compare([FILES[i] for i in order], **SYSTEM, belt_speed=0.02, draws=150)
    xr.testing.assert_equal(again, compared)


def test_a_wide_table_compares_as_its_columns_do(compared):
    wide = stickslip.compare(points_path("configs/measured/table.csv"), **SYSTEM, belt_speed=0.02, draws=150)
    assert list(wide["material"].values) == ["grease B", "grease A", "dry"]
    for i in (0, 2):  # a point of grease A is missing there
        np.testing.assert_allclose(wide["quiet_above"][i], compared["quiet_above"][i], rtol=1e-9)
        np.testing.assert_allclose(wide["quiet_above_high"][i], compared["quiet_above_high"][i], rtol=1e-9)
    assert abs(float(wide["quiet_above"][1]) / float(compared["quiet_above"][1]) - 1) < 0.1


def test_draws_have_the_mean_and_the_covariance_of_the_fit_and_stay_within_its_bounds():
    random = np.random.default_rng(4)
    speed = np.linspace(0, 0.4, 60)
    fit = fit_curve(speed, law(speed, 0.27, 0.19, 0.15, 0.024) + random.normal(0, 0.004, speed.size), 0.004)
    drawn = draw_curves(fit, 20_000)
    values = np.stack(list(drawn.coefficients.values()))
    np.testing.assert_allclose(values.mean(axis=1), list(fit.coefficients().values()), rtol=0.01)
    scale = np.sqrt(np.outer(*[np.diag(fit.covariance)] * 2))
    np.testing.assert_allclose(np.cov(values) / scale, fit.covariance / scale, atol=0.04)
    few = fit_curve(speed[:8], law(speed[:8], 0.08, 0.3, 0.01, 0.02) + random.normal(0, 0.003, 8))
    assert all((draw_curves(few, 100).coefficients[name] >= 0).all() for name in ("a1", "a2", "a3", "a4"))


def test_friction_that_only_rises_is_quiet_throughout_and_says_so():
    points = {"oil": (SPEED, 0.1 - 0.05 * np.exp(-SPEED / 0.05)), "dry": (SPEED, law(SPEED, 0.27, 0.19, 0.15, 0.024))}
    ds = stickslip.compare(points, **SYSTEM, belt_speed=0.05, draws=50)
    assert list(ds["material"].values) == ["oil", "dry"] and ds["quiet_state"].values.tolist() == [2, 1]
    assert float(ds["quiet_above"][0]) == ds.attrs["searched_from"] and np.isinf(ds["margin"][0])
    assert float(ds["quiet_above_high"][0]) == 0.0


def test_friction_that_falls_without_end_vibrates_throughout_unless_a_damper_ends_it(tmp_path):
    (tmp_path / "grease.csv").write_text(FALLING)
    done = call("compare", tmp_path / "grease.csv", *OPTIONS, "--draws", 0, "--speed", "5 mm/s")
    assert done.exit_code == 0, done.output
    (row,) = (line.split() for line in done.stdout.splitlines() if line.startswith("1 "))
    assert row[2] == ">" and row[row.index("stick_slip") + 1] == "<" and "assumed)" in done.stdout
    wide = call("compare", tmp_path / "grease.csv", *OPTIONS, "--draws", 50, "--damping", "5 N s/m", "--json")
    (one,) = json.loads(wide.stdout)["materials"]
    assert one["quiet_state"] == "border" and one["quiet_above_low"] is None  # five points tell nothing of the scatter


@pytest.mark.parametrize("kind", ["nc", "zarr"])
def test_a_result_comes_back_from_its_file(compared, tmp_path, kind):
    from stickslip.files import writing

    writing.write(compared, tmp_path / f"found.{kind}")
    back = stickslip.open(tmp_path / f"found.{kind}").load()
    xr.testing.assert_equal(back, compared)
    again = stickslip.run(stickslip.config.reader.parse_config(str(back.attrs["configuration"])))
    np.testing.assert_allclose(np.nanmax(again["border"], axis=1), compared["quiet_above"], rtol=3e-9)


def test_the_command_writes_table_workbook_page_plot_and_answer(tmp_path):
    names = {kind: tmp_path / f"found.{kind}" for kind in ("csv", "xlsx", "nc", "png", "html")}
    outputs = [word for kind in ("csv", "xlsx", "nc") for word in ("-o", names[kind])]
    done = call("compare", *FILES, *OPTIONS, "--damping", 1, "--speed", "20 mm/s", "--draws", 100, *outputs,
                "--plot", names["png"], "--report", names["html"])  # fmt: skip
    assert done.exit_code == 0, done.output
    rows = [line.split() for line in done.stdout.splitlines() if line.split()[:1] in (["1"], ["2"], ["3"])]
    assert [row[1] for row in rows] == ["grease_b", "grease_a", "dry"]
    ds = stickslip.open(names["nc"])
    for table in (pd.read_csv(names["csv"]), pd.read_excel(names["xlsx"], "data")):
        assert list(table["material"]) == list(ds["material"].values)
        np.testing.assert_allclose(table["quiet_above [mm/s]"], 1e3 * ds["quiet_above"], rtol=5e-6)
        assert list(table["quiet_state"]) == ["border"] * 3 and "stick_slip" in list(table["regime"])
    about = pd.read_excel(names["xlsx"], "about").set_index("what")["value"]
    assert about["title"] == "3 materials compared" and "belt_speed" in about["configuration"]
    page = names["html"].read_text()
    assert page.startswith("<!DOCTYPE html>") and "at 20 mm/s: " in page
    assert "Warning" not in page and "spring stiffness 5 N/mm" in page
    assert "<img" in page and "http://" not in page.replace("http://www.w3.org", "")
    told = json.loads(call("compare", *FILES, *OPTIONS, "--damping", 1, "--draws", 100, "--json").stdout)
    assert [one["name"] for one in told["materials"]] == ["grease_b", "grease_a", "dry"]
    assert told["materials"][0]["quiet_above"] == pytest.approx(float(ds["quiet_above"][0]), rel=1e-8)
    assert told["units"]["quiet_above"] == "m s-1" and told["system"]["mass"] == 0.1


@cases("materials.yaml")
def test_wrong_input_is_refused_before_anything_is_computed(words, said):
    options = [*zip(OPTIONS[::2], OPTIONS[1::2], strict=True)]
    others = [word for pair in options for word in pair if pair[0] not in words]
    done = call("compare", FILES[0], *others, *words)
    assert done.exit_code == 2 and said in done.stderr


def test_plot_and_inspect_know_a_comparison_from_its_file(compared, tmp_path, monkeypatch):
    from stickslip.files import writing

    monkeypatch.chdir(tmp_path)
    writing.write(compared, "found.nc")
    done = call("plot", "found.nc")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "found.png").read_bytes().startswith(b"\x89PNG") and not done.stderr
    told = call("plot", "found.nc", "-o", "found.html")
    assert told.exit_code == 0 and "Which is quiet" in (tmp_path / "found.html").read_text()
    told = call("inspect", "found.nc")
    assert told.exit_code == 0 and "grease_b" in told.stdout and "quiet above" in told.stdout
    assert json.loads(call("inspect", "found.nc", "--json").stdout)["materials"][2]["name"] == "dry"


def test_a_forgotten_unit_is_asked_about_as_in_a_configuration(tmp_path):
    options = ["--load", "10 N", "--draws", 0, "--damping", 1]
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        done = call("compare", FILES[0], "--mass", 100, "--stiffness", 5, "--speed", 20, *options)
    assert done.exit_code == 0 and "did you mean 100 g?" in done.stderr
    assert "mass 100 kg, spring stiffness 5 N/m," in done.stdout
    assert "lies beyond the speeds that were measured" in done.stdout and "damping 0" not in done.stdout.lower()
    with pytest.warns(UnitWarning, match="got 100 kg; did you mean 100 g"):
        ds = stickslip.compare(FILES[0], mass=100, stiffness=5000, normal_load=10, draws=0)
    assert ds.attrs["damping_assumed"] == 1


def test_points_that_may_fall_for_ever_leave_the_interval_open_upwards_unless_a_damper_ends_it():
    """Points of a curve with a2 = 0: about half of the curves drawn fall for ever."""
    noise = 0.0012 * np.array([1, -1, 0.5, -0.5, 1, 0, -1, 0.8, -0.6, 0.4, -0.9, 0.7, 0.6, -0.5])
    points = {"oil": (SPEED, law(SPEED, 0.1, 0.004, 0.05, 0.02) + noise)}
    ds = stickslip.compare(points, **{**SYSTEM, "damping": 0}, belt_speed=0.05, draws=200)
    assert np.isinf(ds["quiet_above_high"][0])
    table = RankTable(ds).table()
    assert "> " in table.rows[0][[*table.words, *table.numbers].index("95 % interval")]
    held = stickslip.compare(points, **{**SYSTEM, "damping": 20}, draws=200)
    assert np.isfinite(held["quiet_above_high"][0])


def test_tables_for_colleagues_show_what_is_printed_and_no_bound_as_a_border(tmp_path):
    """Oil is quiet throughout, the grease vibrates throughout: neither has a border."""
    (tmp_path / "grease.csv").write_text(FALLING)
    oil = "\n".join(f"{1000 * w}, {0.1 + 0.1 * w - 0.05 * np.exp(-w / 0.05)}" for w in SPEED)
    (tmp_path / "oil.csv").write_text(f"speed [mm/s], mu\n{oil}\n")
    names = [tmp_path / "ranks.csv", tmp_path / "ranks.xlsx", tmp_path / "ranks.nc"]
    done = call("compare", tmp_path / "grease.csv", tmp_path / "oil.csv", FILES[0], *OPTIONS, "--draws", 0,
                "--speed", "5 mm/s", *(word for name in names for word in ("-o", name)))  # fmt: skip
    assert done.exit_code == 0, done.output
    table = pd.read_csv(names[0]).set_index("material")
    assert list(table["quiet_state"]) == ["quiet_throughout", "border", "vibrates_throughout"]
    assert list(table["quiet_above [mm/s]"].isna()) == list(table["margin"].isna()) == [True, False, True]
    assert table["quiet_above [mm/s]"]["dry"] < table["searched_to [mm/s]"]["dry"]
    book = load_workbook(names[1])
    assert book.sheetnames == ["data", "about"]
    assert [row[0].value for row in book["data"].iter_rows()] == ["material", *table.index]
    rows = [line for line in done.stdout.splitlines() if line.split()[:1] in (["1"], ["2"], ["3"])]
    assert [row.split()[2] for row in rows][::2] == ["<", ">"]
    assert "grease: Friction falls" in done.stdout


def test_the_faults_of_all_files_are_told_at_once(tmp_path):
    """A heading that nobody knows, too few points, and friction over waiting time."""
    (tmp_path / "odd.csv").write_text("this, that\n1, 2\n2, 3\n")
    (tmp_path / "few.csv").write_text("speed [mm/s], mu\n1, 0.2\n2, 0.19\n")
    (tmp_path / "aged.csv").write_text("time [s], mu\n1, 0.2\n10, 0.21\n100, 0.22\n1000, 0.23\n")
    names = [tmp_path / f"{name}.csv" for name in ("odd", "few", "aged")]
    with pytest.raises(ConfigError) as raised:
        stickslip.compare([*names, FILES[0]], **SYSTEM)
    assert all(str(name) in str(raised.value) for name in names) and str(FILES[0]) not in str(raised.value)
    with pytest.raises(ValueError, match="expected at least one"):
        stickslip.compare({}, **SYSTEM)
    done = call("compare", *names, FILES[0], *OPTIONS)
    assert done.exit_code == 2 and all(str(name) in done.stderr for name in names)
    assert "hint: stickslip fit ranks lubricants by their ageing" in done.stderr


def test_speeds_that_no_contact_has_are_asked_about_and_never_ranked(tmp_path):
    """The heading says m/s, the numbers are mm/s."""
    lines = [f"{1000 * w:g};{mu:.4f}" for w, mu in zip(SPEED, law(SPEED, 0.1, 0.2, 0.03, 0.02), strict=True)]
    (tmp_path / "wrong.csv").write_text("\n".join(["v [m/s];mu", *lines]))
    with pytest.warns(UnitWarning, match="measured at up to 400 m/s; did you mean 400 mm/s"):
        ds = stickslip.compare([tmp_path / "wrong.csv", FILES[0]], **SYSTEM, draws=0)
    assert ds["material"].values.tolist() == ["dry", "wrong"] and np.isnan(ds["rank"].values[1])
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert "did you mean 400 mm/s" in call("fit", tmp_path / "wrong.csv").stderr


def test_a_plot_of_materials_says_what_to_give_instead():
    refuses_what_it_cannot_draw(stickslip.plots.plot_materials)


@pytest.mark.slow
def test_a_comparison_is_drawn_as_the_command_draws_it(tmp_path):
    ds = stickslip.compare(FILES[:1], **SYSTEM, draws=0)
    assert draws_what_the_command_draws(ds, tmp_path) == "comparison"


def test_how_far_a_comparison_is_rises_to_all_curves(tmp_path, monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.0)
    moves = []
    stickslip.compare(FILES[:2], **SYSTEM, draws=20, progress=lambda done, total: moves.append((done, total)))
    assert moves[0][0] < 42 and moves[-1] == (42, 42) and (np.diff([done for done, _ in moves]) >= 0).all()
    done = call("compare", FILES[0], *OPTIONS, "--draws", "20")
    assert done.exit_code == 0 and "21 of 21 curves compared" in done.stderr


def test_exported_curves_are_read_as_points_again(tmp_path):
    """Material, speed and friction, by the headings of the export."""
    speed = np.geomspace(1e-3, 0.4, 12)
    points = {"dry": (speed, 0.3 + 0.1 * np.exp(-speed / 0.02) + 0.2 * speed), "oil": (speed, 0.1 + 0.2 * speed)}
    ds = stickslip.compare(points, mass=0.1, stiffness=5000, normal_load=10, damping=1, draws=0)
    export.write_table(ds, tmp_path / "curves.csv", ["friction"])
    back = read_materials(tmp_path / "curves.csv", CURVE_COLUMNS)
    for name in ("dry", "oil"):
        one = ds["friction"].sel(material=name)
        np.testing.assert_allclose(back[name]["mu"], one.values, rtol=5e-6)
        np.testing.assert_allclose(back[name]["speed"], ds["slip_speed"].values, rtol=5e-6)
