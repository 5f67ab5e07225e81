"""How often intervals hold the truth: trials with `held`, by name whether an interval that is printed does."""

import numpy as np

LEAST, MOST = 0.92, 0.98  # coverage of 95 % intervals that is right


def held(trials, name):
    return [trial.held[name] for trial in trials if name in trial.held]


def table(what, rows, columns):
    """Lines of Markdown. rows : trials by title. columns : what is said of trials, by heading."""
    headings = [what, "number", *columns]
    yield f"| {' | '.join(headings)} |"
    yield f"|{' --- |' * len(headings)}"
    for title, trials in rows.items():
        entries = [text(trials) if trials else "" for text in columns.values()]
        yield f"| {' | '.join([title, str(len(trials)), *entries])} |"


def wrong(title, trials, names, enough):
    """What is held too seldom or too often, where there are enough trials."""
    for name in names:
        of_name = held(trials, name)
        if len(of_name) >= enough and not LEAST <= np.mean(of_name) <= MOST:
            yield f"{title}: {name} is held in {100 * np.mean(of_name):.1f} % of {len(of_name)}"
