"""Torque of a held disk without sound, events or control events.

For measuring what the physics costs; the step is `two_disk`'s.

Thread: main.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry_point
from overview_dsp.kernels.friction_lookup import friction_at
from overview_dsp.kernels.two_disk import midpoint_speed


@entry_point
def disk_alone(f64, table, input_angle, torque):
    """Compute the torque at each sample of a held disk that starts at rest at 0.

    Parameters
    ----------
    f64 : float64 [layout.TOTAL]
        Only coefficients and the surface are read.
    table : int64
        First column of the surface's friction table.
    input_angle : float64 [frames]
        Input position, cells, without smoothing.
    torque : float64 [frames]
        Overwritten, N m.
    """
    spring = f64[layout.C_SPRING_HELD]
    inertia = f64[layout.C_INERTIA]
    denominator = inertia * (2.0 + 0.5 * spring)
    to_omega = f64[layout.C_OMEGA]
    x = 0.0
    half = 0.0
    for n in range(torque.size):
        friction = friction_at(f64, table, x + half)
        middle = midpoint_speed(
            2.0 * half, input_angle[n] - x, spring, inertia, denominator, friction
        )
        x = x + middle
        half = middle - half
        torque[n] = friction * (middle * to_omega)
