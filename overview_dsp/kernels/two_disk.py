"""Disk 1 on its two shafts: one implicit-midpoint step in closed form.

    theta1' = omega1
    omega1' = (-k * theta1 - B * omega1 + s * k2 * theta2) / J,    k = k1 + s * k2    (paper, eq. 2)

In the surface's own unit x = theta1 * (k1 + k2)/k2 (cells), u = theta2 (cells), v in cells a
sample and K = k/J * dt**2 this is  x'' = K * (s*u - x) - (B*dt/J) * v,  because with s = 1 the
spring rests exactly where the finger points. The midpoint rule with the midpoint speed vm,

    v1 - v0 = K * (s*u - x0 - vm/2) - (B*dt/J) * vm,   vm = (v0 + v1)/2,   x1 = x0 + vm,

is linear in vm. Scaled by J/dt so that the table's B needs no factor, it has one division:

    vm = (J/dt) * (2*v0 + K*(s*u - x0)) / ((J/dt) * (2 + K/2) + B)

Every step keeps the contract's energy ledger, dE = dt*(-B*wm**2 + s*k2*theta2*wm), for any B >= 0
and any dt; it is of second order when B is taken at the predicted midpoint x0 + v0/2. Where the
disk runs into a steep ridge that midpoint is not reached: there B is sought at the step's own
midpoint x0 + vm/2, in a few rounds (`MISSED`, `ROUNDS`), so that how deep the disk comes, and with
it how long the ridge holds it, depends little on the sample rate.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined

MISSED = 0.002  # cells: a predicted midpoint further off is corrected
ROUNDS = 4  # of the correction, each half of the way: plain ones swing from edge to edge


@inlined
def midpoint_speed(v, stretch, spring, inertia, denominator, friction):
    """The step's midpoint speed vm (cells a sample).

    `stretch` is s*u - x, `spring` K, `inertia` J/dt, `denominator` (J/dt)*(2 + K/2), `friction` B.
    """
    return inertia * (2.0 * v + spring * stretch) / (denominator + friction)
