"""Butcher tableaux: a method is data.

The stepping code in `runge_kutta.py` reads these numbers and never changes for another explicit pair of the same size
(seven stages, first same as last).
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class ButcherTableau:
    """An embedded explicit Runge-Kutta pair.

            c | A          nodes   | matrix (strictly lower triangular, row i has i entries)
            --+---         --------+--------
              | b                  | weights         solution of order `order`
              | b - b^             | error_weights   solution minus embedded solution

    Refused unless every row of the matrix sums to its node, the weights sum to 1 and the error weights to 0.
    Those sums are weak checks (an entry can be wrong and pass): the tests hold all 17 conditions of order 5.
    """

    nodes: tuple[float, ...]
    matrix: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    error_weights: tuple[float, ...]
    order: int

    def __post_init__(self):
        for i, (node, row) in enumerate(zip(self.nodes, self.matrix, strict=True)):
            if len(row) != i or abs(sum(row) - node) > 1e-14:
                raise ValueError(f"row {i} of the matrix must have {i} entries that sum to {node}, got {row}")
        if abs(sum(self.weights) - 1.0) > 1e-14:
            raise ValueError(f"weights must sum to 1, got {sum(self.weights)!r}")
        if abs(sum(self.error_weights)) > 1e-14:
            raise ValueError(f"error_weights must sum to 0, got {sum(self.error_weights)!r}")

    @property
    def first_same_as_last(self) -> bool:
        """Return whether the last stage of a step is the first of the next, so that it comes free."""
        return self.matrix[-1] + (0.0,) == self.weights


# Ch. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption,
# Computers & Mathematics with Applications 62 (2011) 770-775.
TSITOURAS_54 = ButcherTableau(
    nodes=(0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0),
    matrix=(
        (),
        (0.161,),
        (-0.008480655492356989, 0.335480655492357),
        (2.8971530571054935, -6.359448489975075, 4.3622954328695815),
        (5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525),
        (5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383),
        (0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774),
    ),
    weights=(
        0.09646076681806523,
        0.01,
        0.4798896504144996,
        1.379008574103742,
        -3.290069515436081,
        2.324710524099774,
        0.0,
    ),
    error_weights=(
        -0.00178001105222577714,
        -0.0008164344596567469,
        0.007880878010261995,
        -0.1447110071732629,
        0.5823571654525552,
        -0.45808210592918697,
        0.015151515151515152,
    ),
    order=5,
)
