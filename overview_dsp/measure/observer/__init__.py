"""An observer says which kind of event was met at each onset, from what a stroke gives alone.

`noticed` finds what is noticed and how it feels or sounds, `human_limits` blurs that as a person
does, `trees` learns which kind it was, `scoring` compares what it says with what was there
(`passages`), `strokes` says which movements it is asked about, `observing` does it all in order.
"""
