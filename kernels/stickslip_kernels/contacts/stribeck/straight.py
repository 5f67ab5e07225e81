"""Straight-line code of a formula in coefficients of series: what a function of Python does with them, written down.

Its loops run when it is written, so that the compiler sees neither loops nor indices, only sums of products.
"""

from ...jit import compiled


class Term:
    """A number that the code will have. lines : the code so far, by what each line computes."""

    def __init__(self, name, lines):
        self.name, self.lines = name, lines

    def _with(self, sign, other, first=True):
        pair = [self.name, other.name if isinstance(other, Term) else repr(float(other))]
        pair = sorted(pair) if sign in "+*" else pair if first else pair[::-1]  # the same product once
        return Term(self.lines.setdefault(f"{pair[0]} {sign} {pair[1]}", f"t{len(self.lines)}"), self.lines)

    def __add__(self, other):
        return self._with("+", other)

    def __sub__(self, other):
        return self._with("-", other)

    def __rsub__(self, other):
        return self._with("-", other, False)

    def __mul__(self, other):
        return self._with("*", other)

    def __truediv__(self, other):
        return self._with("/", other)

    def __rtruediv__(self, other):
        return self._with("/", other, False)

    def __neg__(self):
        return self._with("*", -1.0)

    __radd__, __rmul__ = __add__, __mul__


def straight(series, n):
    """series(n, z, x, d, delta) for this n, compiled as a function of the other four, of which it takes sums, products,
    quotients.
    """
    lines = {}
    of_z, of_x, of_d = (
        tuple(Term(f"{name}[{k}]", lines) for k in range(last + 1)) for name, last in (("z", n), ("x", n), ("d", n - 1))
    )
    result = series(n, of_z, of_x, of_d, Term("delta", lines))
    body = [f"    {name} = {formula}" for formula, name in lines.items()]
    end = result.name if isinstance(result, Term) else repr(float(result))
    space = {}
    exec("\n".join(["def coefficient(z, x, d, delta):", *body, f"    return {end}"]), space)  # noqa: S102
    return compiled(space["coefficient"], inline=True, keep=False)
