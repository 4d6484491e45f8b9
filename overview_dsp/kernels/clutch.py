"""The slip clutch on shaft 2: it slips where the disk would run ahead of the hand.

Against friction B a disk that moves at the pace p (cells a sample) rests on a spring stretched by
B*p / ((k1 + k2)*dt) cells. The clutch lets shaft 2 be stretched by no more than that for `catch`
times the hand's own pace, so the rest position used in the step is

    clamp(theta2, x - reach, x + reach),   reach = B * catch * pace / ((k1 + k2)*dt)

and its torque is never more than the rigid shaft's, nor of another sign. A disk that an event held
back follows at about the hand's pace, where the rigid shaft would throw it at what comes next; a
tap, which has no pace, unfolds in a chosen time. The energy ledger of `two_disk` holds with the
rest position that was used.

The pace is the smoothed input's, smoothed once more. A finger that rests keeps the pace it had, and
a jump of the input isn't a pace; the disk is always let go fast enough to arrive within a few
unfolding times, however slowly the hand moved last.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose

OFF = 1e300  # for `catch`: shaft 2 is rigid


@inlined
def follow_hand(pace, moved, smoothing, least, most):
    """The hand's pace after a sample in which the smoothed input `moved` (cells, >= 0)."""
    counted = choose(moved > least, moved, pace)
    counted = choose(moved < most, counted, pace)
    return pace + smoothing * (counted - pace)


@inlined
def reach_of(stretch, pace, unfold, friction, catch):
    """How far shaft 2 may be stretched (cells) where a rigid one would be by `stretch`.

    `unfold` is the part of that way that is let go in a sample at least, `catch` the reach for a
    pace of one cell a sample and a friction of 1 N m s/rad.
    """
    least = abs(stretch) * unfold
    return choose(least > pace, least, pace) * (friction * catch)


@inlined
def slipped(stretch, reach):
    """How far shaft 2 is stretched (cells) where a rigid one would be by `stretch`."""
    return choose(stretch > 0.0, reach, -reach)
