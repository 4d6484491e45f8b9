"""Models of the players of haptic clips: the amplitude a finger gets of a document, by device.

One file a player. Each gives float64 (n,), the amplitude at each millisecond, strikes included.
"""
