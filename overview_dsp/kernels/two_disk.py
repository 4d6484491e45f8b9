"""Disk 1 on its two shafts: an implicit midpoint step in closed form.

    theta1' = omega1
    omega1' = (-k * theta1 - B * omega1 + s * k2 * theta2) / J,    k = k1 + s * k2    (paper, eq. 2)

In the surface's own unit x = theta1 * (k1 + k2)/k2 (cells), u = theta2 (cells), v in cells a
sample and K = k/J * dt**2 this is  x'' = K * (s*u - x) - (B*dt/J) * v,  because with s = 1 the
spring rests exactly at the input angle. The midpoint rule with the midpoint speed vm,

    v1 - v0 = K * (s*u - x0 - vm/2) - (B*dt/J) * vm,   vm = (v0 + v1)/2,   x1 = x0 + vm,

is linear in vm. Scaled by J/dt, so that the table's B needs no factor, it has one division:

    vm = (J/dt) * (2*v0 + K*(s*u - x0)) / ((J/dt) * (2 + K/2) + B)

Every step satisfies the energy balance dE = dt*(-B*wm**2 + s*k2*theta2*wm) for any B >= 0
and any dt; it is of second order when B is taken at the predicted midpoint x0 + v0/2.

Friction takes the impulse  integral of B*v dt = integral of B dx  at any speed. Where a step
may cross a steep edge, B is therefore its mean over the step (`friction_lookup.mean_friction`):

    vm * (J/dt) * (2 + K/2) + I(x0 + vm) - I(x0) = (J/dt) * (2*v0 + K*(s*u - x0)),   I' = B

whose left side is monotonic, so Newton's method finds its only root. Then J/dt*v + I(x) is
conserved except for the springs, as in continuous time. The depth that the disk reaches in a ridge,
and how long the ridge holds it, are thus exact at any sample rate.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined


@inlined
def midpoint_speed(v, stretch, spring, inertia, denominator, friction):
    """Return the step's midpoint speed vm (cells per sample).

    `stretch` is s*u - x, `spring` K, `inertia` J/dt, `denominator` (J/dt)*(2 + K/2), `friction` B.
    """
    return inertia * (2.0 * v + spring * stretch) / (denominator + friction)
