"""diffrax on JAX (CPU): all cells as one vmap, slip by diffeqsolve with a terminal event and Newton root.

A while loop alternates break-away and re-stick; under vmap every cell waits for the slowest. Tsit5 at rtol 1e-6, Dopri8
below. Compiled once per number of cells, outside the timing.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from peers import Peer, needs
from problem import A2, A3, A4, MU_START, Answer, Cells


@cache
def solver(rtol: float, horizon: float):
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

    jax.config.update("jax_enable_x64", True)

    def motion(t, state, cell):
        y, w = state
        k, belt = cell
        return k * (belt - w), y - A2 * w - A3 * (jnp.exp(-w / A4) - 1.0)

    method = diffrax.Tsit5() if rtol > 1e-8 else diffrax.Dopri8()
    control = diffrax.PIDController(rtol=rtol, atol=1e-3 * rtol)
    event = diffrax.Event(
        lambda t, y, args, **_: y[1], optimistix.Newton(rtol=1e-2 * rtol, atol=1e-2 * rtol), direction=False
    )
    growth = A3 / A4 - A2

    def one(k, belt):
        def slip(carry):
            t, x, first_t, first_x, _, _ = carry
            release = t + (MU_START / k - x) / belt
            dt = 1e-4 / jnp.maximum(growth, jnp.sqrt(k))
            w = k * belt * dt**2 * (1 / 2 + growth * dt / 6 + (growth**2 - k) * dt**2 / 24)
            start = k * belt * dt * (1 - k * dt**2 / 6), w
            begin = jnp.minimum(release + dt, horizon)
            run = diffrax.diffeqsolve(
                diffrax.ODETerm(motion),
                method,
                begin,
                horizon,
                1e-3 / jnp.sqrt(k),
                start,
                (k, belt),
                saveat=diffrax.SaveAt(t1=True),
                stepsize_controller=control,
                event=event,
                max_steps=100_000,
                throw=False,
            )
            end, y, w = run.ts[-1], run.ys[0][-1], run.ys[1][-1]
            slid = release < horizon
            stuck = slid & (run.result == diffrax.RESULTS.event_occurred)
            x_end = jnp.where(slid, (y + MU_START) / k, x + belt * (horizon - t))
            new = stuck & jnp.isnan(first_t)
            return (
                jnp.where(stuck, end, horizon),
                x_end,
                jnp.where(new, end, first_t),
                jnp.where(new, x_end, first_x),
                jnp.where(slid, belt - w, belt),
                jnp.logical_not(stuck),
            )

        start = (jnp.zeros_like(k), jnp.zeros_like(k), k * jnp.nan, k * jnp.nan, belt, jnp.array(False))
        found = jax.lax.while_loop(lambda carry: ~carry[-1], slip, start)
        return found[2], found[3], found[1], found[4]

    return jax.jit(jax.vmap(one))


def solve(cells: Cells, horizon: float, rtol: float) -> Answer:
    found = solver(rtol, horizon)(cells.k, cells.belt)
    return Answer(*(np.asarray(values) for values in found))


PEERS = [
    Peer("diffrax, vmap (Tsit5 / Dopri8)", "Event + Newton", solve, {1e-6: 256, 1e-9: 256}, needs("jax", "diffrax"))
]
