"""All frames of a board, without its answers."""

from __future__ import annotations

from overview_dsp.devices.force_feedback.board_loop import board_table


def all_frames(loop, points):
    """The frames of a loop for a board with `points` points."""
    loop._table = board_table(loop._surface, points, loop._bare)
    loop._table_id = loop._disk_id = 1
    parts = range(len(loop._table.parts))
    return [loop._disk(), *map(loop._part_of, parts), loop._use()]
