"""How often intervals hold the truth: a row for each trial, and in the column of a number 1.0 where its interval holds
the truth, 0.0 where it does not, NaN where none is printed."""

from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pandas as pd

LEAST, MOST = 0.92, 0.98  # coverage of 95 % intervals that is right


def trials(trial, count, seed):
    """What `trial` returns for so many pairs of the seed and a number."""
    with ProcessPoolExecutor() as pool:
        return pd.DataFrame(list(pool.map(trial, [(seed, i) for i in range(count)], chunksize=10)))


def table(what, every, rows, columns):
    """Lines of Markdown. rows : conditions on trials by title. columns : what is said of trials, by heading."""
    headings = [what, "number", *columns]
    yield f"| {' | '.join(headings)} |"
    yield f"|{' --- |' * len(headings)}"
    for title, condition in rows.items():
        chosen = every.query(condition) if condition else every
        entries = [text(chosen) if len(chosen) else "" for text in columns.values()]
        yield f"| {' | '.join([title, str(len(chosen)), *entries])} |"


def covered(chosen, name, more=""):
    """Coverage in %, and in brackets the share of trials whose interval is printed."""
    shown = chosen[name].dropna()
    share = f"{100 * len(shown) / len(chosen):.0f} %"
    return f"{100 * shown.mean():.1f} ({share}{more})" if len(shown) else ""


def wrong(title, chosen, names, enough):
    """What is held too seldom or too often, where there are enough trials."""
    for name in names:
        shown = chosen[name].dropna()
        if len(shown) >= enough and not LEAST <= np.mean(shown) <= MOST:
            yield f"{title}: {name} is held in {100 * np.mean(shown):.1f} % of {len(shown)}"
