"""Football from other vendors and lists: Metrica, Wyscout, openfootball, minutes."""
