"""Four greases as a laboratory measured them, one of them three times, and what a report of their comparison says."""

import json
import re

import numpy as np
import pandas as pd
import pytest

import stickslip
from helpers.commands import call
from stickslip_materials.compare.table import RankTable

TRUE = {"Fett_A_1": (0.1, 0.6, 0.05, 15), "Fett_A_2": (0.103, 0.6, 0.05, 15), "Fett_A_3": (0.097, 0.6, 0.05, 15),
        "Fett_B": (0.095, 0.16, 0.004, 20), "Fett_C": (0.09, 0.2, 0.09, 6)}  # a1, a2 (s/m), a3, a4 (mm/s)  # fmt: skip
OPTIONS = ["--mass", "120 g", "--stiffness", "8 N/mm", "--load", "15 N", "--speed", "10..60 mm/s"]
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


def test_every_file_and_every_number_reaches_programs_excel_and_the_page(folder):
    table, page, whole = (folder / f"x.{suffix}" for suffix in ("csv", "html", "nc"))
    words = ["compare", *sorted(folder.glob("Fett*.csv")), *OPTIONS, "--damping", "2 %", "--draws", 120, "--json",
             "-o", table, "-o", whole, "--report", page, "--title", "Fette"]  # fmt: skip
    done = call(*words)
    assert done.exit_code == 0, done.output
    read = json.loads(done.stdout)["read"]
    assert set(read) == set(TRUE) and all(columns["lines_above"] for columns in read.values())
    rows = pd.read_csv(table, encoding="utf-8-sig", dtype=str).set_index("material")
    assert all(rows["file"][name].endswith(f"{name}.csv") for name in TRUE)
    counts = [cell for name in ("rank", "points", "fit_good") for cell in rows[name]]
    assert all(re.fullmatch(r"\d+", cell) for cell in counts)
    assert not re.search(r"(?<![a-z])inf", table.read_text(encoding="utf-8-sig"))  # open ends are empty
    assert "<h1>Fette</h1>" in page.read_text(encoding="utf-8")
    ds = stickslip.open(whole).load()
    assert "2 % of critical" in dict(RankTable(ds).conditions())["viscous damping coefficient"]
    ranks = RankTable(ds, "mm/s").table()
    best = ranks.rows[0][[*ranks.words, *ranks.numbers].index("margin")]
    assert np.isinf(ds["margin"][0]) and best == f"> {0.01 / ds.attrs['searched_from']:.3g}"
