"""Observer: a classifier with human limits that names the event kind of each onset in a stroke.

`features` finds the onsets of a stroke and how each feels and sounds. `observing` adds sensory
noise, trains a forest (`trees`) and evaluates it on other timelines. `scoring` compares its
answers with the events that the disk passed (`strokes`). `report` writes tables and warnings.
"""
