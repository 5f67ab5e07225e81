"""Four greases as a laboratory measured them, one of them three times, and what a report of their comparison says."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import stickslip
from stickslip.cli import main
from stickslip_materials.compare.table import RankTable

TRUE = {"Fett_A_1": (0.1, 0.6, 0.05, 15), "Fett_A_2": (0.103, 0.6, 0.05, 15), "Fett_A_3": (0.097, 0.6, 0.05, 15),
        "Fett_B": (0.095, 0.16, 0.004, 20), "Fett_C": (0.09, 0.2, 0.09, 6)}  # a1, a2 (s/m), a3, a4 (mm/s)  # fmt: skip
OPTIONS = ["--mass", "120 g", "--stiffness", "8 N/mm", "--load", "15 N", "--same", "Fett_A*", "--speed", "10..60 mm/s"]
HEAD = "Prüfbericht;;;\nPrüflast;15;N;\n\nNr.;Gleitgeschw. [mm/s];Reibungszahl µ [-];Std.-Abw.\n"


def measured(true, seed):
    a1, a2, a3, a4 = true
    speed = np.round(np.geomspace(1, 155.57, 16), 2)
    mu = a1 + a2 * speed / 1000 + a3 * np.exp(-speed / a4)
    return speed, mu * (1 + 0.015 * np.random.default_rng(seed).standard_normal(speed.size)), 0.015 * mu


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("greases")
    for seed, (name, true) in enumerate(TRUE.items()):
        rows = [
            f"{i};{v:.2f};{mu:.4f};{sd:.4f}" for i, (v, mu, sd) in enumerate(zip(*measured(true, seed), strict=True), 1)
        ]
        (folder / f"{name}.csv").write_bytes((HEAD + "\n".join(rows).replace(".", ",")).encode("cp1252"))
    return folder


@pytest.fixture(scope="module")
def report(folder):
    """What programs, Excel and the reader of the page are told, and the dataset."""
    table, page, whole = (folder / f"x.{suffix}" for suffix in ("csv", "html", "nc"))
    words = ["compare", *sorted(folder.glob("Fett*.csv")), *OPTIONS, "--damping", "2 %", "--draws", 120, "--json",
             "-o", table, "-o", whole, "--report", page, "--title", "Fette"]  # fmt: skip
    done = CliRunner().invoke(main, list(map(str, words)))
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout), table, page.read_text(encoding="utf-8"), stickslip.open(whole).load()


@pytest.fixture(scope="module")
def compared(report):
    return report[3]


def test_every_repeat_is_named_with_its_file(report):
    told, table, *_ = report
    assert set(told["read"]) == set(TRUE) and all(one["lines_above"] for one in told["read"].values())
    row = pd.read_csv(table, encoding="utf-8-sig").set_index("material").loc["Fett_A"]
    assert [f"Fett_A_{i}.csv" in row["file"] for i in (1, 2, 3)] == [True] * 3


def test_a_table_for_excel_has_whole_counts_and_empty_open_ends(report):
    _, table, *_ = report
    text = table.read_text(encoding="utf-8-sig")
    columns = pd.read_csv(table, encoding="utf-8-sig", dtype=str)
    assert all(
        re.fullmatch(r"\d+", cell) for name in ("rank", "draws_used", "points", "fit_good") for cell in columns[name]
    )
    assert not re.search(r"(?<![a-z])inf", text)


def test_what_is_uncertain_is_called_probable_and_what_vibrates_in_part_is_no_loss(compared):
    said = RankTable(compared, "mm/s").answer()
    chance = compared["quiet_probability"].sel(material="Fett_B").item()
    assert ("Fett_B (P(quiet)" in said) and ("is probably quiet throughout" in said) == (0.5 <= chance < 0.975)
    border = 1000 * compared["quiet_above"].sel(material="Fett_A").item()
    assert f"Fett_A (above {border:.3g} mm/s) is quiet in a part of it" in said and "Fett_C" in said.split("; ")[-1]
    assert said.split("; ")[-1].endswith("vibrates.")


def test_the_curves_drawn_are_quiet_or_vibrate_or_have_no_verdict(compared):
    open_ = compared["undecided_probability"].values
    assert (open_ >= 0).all() and (compared["quiet_probability"].values + open_ <= 1).all()
    assert compared["draws_used"].dtype.kind == "i"


def test_the_page_has_its_title_and_no_jargon(report):
    _, _, page, _ = report
    assert "<h1>Fette</h1>" in page
    table = page.split("Which is quiet")[1].split("</table>")[0]
    assert not any(word in table for word in ("Eq. (3)", "stick_slip", "see below", "mu_start"))


def test_the_margin_of_what_is_quiet_throughout_is_a_bound_like_others(compared):
    best = next(one.cells[0] for one in RankTable(compared, "mm/s").columns() if one.name == "margin")
    assert np.isinf(compared["margin"][0]) and best == f"> x {0.01 / compared.attrs['searched_from']:.3g}"


def test_the_table_says_for_which_damping_it_is(folder):
    files = map(str, sorted(folder.glob("Fett*.csv")))
    done = CliRunner().invoke(main, ["compare", *files, *OPTIONS, "--damping", "1 %", "--draws", "0"])
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("system"))
    assert "1 % of critical" in line
    assert done.stdout.count("left out above the header") == 1 and "Fett_A_3.csv" in done.stdout
