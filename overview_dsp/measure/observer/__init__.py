"""An observer: from what a stroke gives alone, which kind of event was met at each onset?

`noticed` finds what is noticed and how it feels or sounds, `human_limits` blurs that as a person
does, `trees` learns which kind it was, `scoring` compares what it says with what was there
(`truth`), `strokes` says which movements it is asked about.
"""
