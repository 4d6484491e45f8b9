"""Names of columns, by role: the vocabulary of all readers of tables.

Names are written like `Column.plain`: lower case, letters and digits only. Lists differ by context:
`tag` is a kind in an event table and a day in a series; `index` counts rows and may be a time.
"""

from __future__ import annotations

import re

EVENT_TIMES = (
    "time", "times", "date", "datetime", "timestamp", "minute", "start", "begin", "onset", "when",
    "times", "clock", "starttime", "startdate", "start_time", "begintime", "from", "in", "at",
    "day", "datum", "zeit", "uhrzeit", "beginn", "fecha", "hora", "heure", "debut", "début",
    "minutes", "min", "second", "seconds", "sec", "secs", "position", "offset", "timecode", "tc",
    "t", "ts", "hour", "hours", "year", "timeofday", "createdat", "elapsed", "eventtime",
    "eventdate", "dtstart", "ms", "milliseconds", "gametime", "matchtime", "startdatetime",
)  # fmt: skip
"""Times of an event table, most likely first; a unit may follow (`time_s`, `start (min)`)."""

EVENT_KINDS = (
    "kind", "event", "eventtype", "type", "what", "category", "action", "eventname", "class",
    "ereignis", "evento", "evenement", "événement", "art", "typ", "tipo", "tag", "code",
    "behavior", "behaviour", "annotation", "incident", "trialtype", "status", "activity",
)  # fmt: skip
"""Kinds of events."""

EVENT_LABELS = (
    "label", "name", "title", "description", "text", "note", "notes", "comment", "summary",
    "subject", "message", "details", "detail", "bezeichnung", "beschreibung", "titel", "nombre",
    "nom", "caption", "remark", "content", "chapter", "marker", "scene", "task", "milestone",
)  # fmt: skip
"""Labels of events."""

EVENT_EXTRAS = (
    "weight", "strength", "importance", "priority", "intensity", "end", "endtime", "enddate",
    "stop", "finish", "out", "to", "duration", "length", "dur", "id", "eventid", "no", "nr",
    "number", "num", "index", "row", "n", "", "color", "colour", "player", "team", "who", "person",
    "user", "author", "channel", "track", "speaker", "fps", "enddatetime", "allday",
    "location", "place", "where", "latitude", "longitude", "lat", "lon", "url", "link", "period",
)  # fmt: skip
"""Other columns of an event table. Numbers in them do not make the table a series."""

EVENT_WEIGHTS = ("weight", "strength", "importance")
"""Weights of events."""

EVENT_ENDS = ("end", "endtime", "enddate", "stop", "finish", "out", "to", "enddatetime")
"""Ends of events."""

EVENT_LENGTHS = ("duration", "length", "dur")
"""Durations of events."""

EVENT_IDS = ("id", "eventid", "uuid", "uid", "guid")
"""Identifiers of events."""

UNIT_SUFFIX = re.compile(r"(?:in)?(ns|us|ms|s|sec|secs|seconds|min|mins|minutes|h|hrs|hours)$")

SERIES_TIMES = (
    "date", "datetime", "timestamp", "time", "ts", "t", "datum", "zeit", "zeitstempel", "fecha",
    "data", "jour", "day", "month", "year", "period", "quarter", "week", "observationdate",
    "opentime", "epoch", "unix", "unixtime", "unixtimestamp", "times", "seconds", "secs", "sec",
    "minutes", "hours", "elapsed", "elapsedtime", "valid", "dateutc", "timeutc", "localtime",
    "createdat", "recordedat", "index", "", "yyyymmdd", "decimaldate", "decimalyear", "jahr",
    "anno", "ano", "año", "mes", "monat", "tag", "tms", "tus", "tsec", "tmin",
)  # fmt: skip
"""Times of a series."""

SERIES_TIME_PARTS = (
    "date", "time", "datum", "zeit", "fecha", "epoch", "unix", "seconds", "elapsed",
)  # fmt: skip
"""Names that contain one of these are times of a series."""

GROUPS = (
    "country", "countryname", "countrycode", "iso3", "nation", "land", "station", "stationid",
    "stationname", "site", "siteid", "subject", "subjectid", "participant", "participantid",
    "patient", "patientid", "channel", "sensor", "sensorid", "device", "deviceid", "symbol",
    "ticker", "entity", "variable", "parameter", "indicator", "metric", "pais", "país",
    "pays", "paese", "estacion", "estación", "stazione", "proband", "kanal",
)  # fmt: skip
"""Columns that distinguish series, whatever their cells are."""

ROW_COUNTERS = ("", "index", "id", "no", "nr", "row", "unnamed0", "rownum", "record", "obs")
"""Columns that may number the rows."""

UTC_OFFSETS = ("utcoffset", "offset", "gmtoffset", "tz", "timezone", "zone", "tzoffset")
"""Offsets from UTC."""

HOURS = ("hour", "hours", "hr", "hh", "hhmm", "stunde", "hora", "heure", "ora", "uur")
"""Hours of the day, beside a date."""

CLOCK_PARTS = ("time", "zeit", "clock", "timeofday", "hhmm", *HOURS)
"""Names that contain one of these are clock times."""

CLOSE = (
    "close", "closelast", "closeprice", "last", "lastprice", "closing", "settle", "price",
    "schlusskurs", "schluss", "zuletzt", "cierre", "dernier", "c",
)  # fmt: skip
"""Closing prices."""

OTHER_PRICES = ("price", "lastprice", "settle")
"""Members of `CLOSE` that are no exchange's closing price."""

PRICES_ALONE = (*OTHER_PRICES, "close", "closelast", "closeprice", "closing", "schlusskurs")
"""Names that mean prices even in a table without other prices."""

OPEN = ("open", "openprice", "eröffnung", "eröffn", "apertura", "ouverture", "o")
"""Opening prices."""

HIGH_LOW = (
    "high", "low", "highprice", "lowprice", "dayhigh", "daylow", "hoch", "tief", "h", "l",
)  # fmt: skip
"""Highest and lowest prices."""

VOLUME = ("volume", "vol", "shares", "sharestraded", "v")
"""Traded volume."""

CALENDAR_PARTS = ("date", "year", "yr", "jahr", "period", "datum", "month", "yyyymm", "decimal")
"""Names that contain one of these are dates."""

TIME_OF_DAY_PREFIXES = (
    "timeofday", "tod", "hour", "hora", "heure", "uhrzeit", "localtime", "clocktime", "daytime",
    "hhmm", "walltime", "wallclock", "departure", "arrival", "timeutc", "timelocal", "opening",
)  # fmt: skip
"""Names that begin so are times of day."""

SECONDS = (
    "t", "ts", "tc", "start", "begin", "onset", "end", "stop", "from", "to", "in", "out", "at",
    "when", "position", "offset", "zeit", "temps", "tiempo", "tempo", "beginn", "clock", "x",
)  # fmt: skip
"""Columns whose plain numbers are seconds, in addition to names that contain `time`."""

EPOCH_PARTS = ("epoch", "unix", "timestamp", "posix")
"""Names that contain one of these count from 1970."""

TIME_UNITS = {
    "nanoseconds": "ns", "µs": "us", "μs": "us", "microseconds": "us", "msec": "ms",
    "milliseconds": "ms",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "mins": "min", "minute": "min",
    "minutes": "min", "hr": "h", "hrs": "h", "hour": "h", "hours": "h", "day": "d", "days": "d",
}  # fmt: skip
"""Units of time, by their other spellings."""

JSON_TIME_PARTS = ("date", "time", "timestamp", "day", "month", "year", "period", "epoch", "unix")
"""Keys of a JSON table that contain one of these are times."""

CHART_LETTERS = {
    "t": "time", "o": "open", "h": "high", "l": "low", "c": "close", "v": "volume",
}  # fmt: skip
"""Meanings of the single letters in share charts."""

CANDLE = ("time", "open", "high", "low", "close", "volume")
"""Columns of a price chart without names."""

QUOTES = ("open", "high", "low", "close", "volume")
"""Columns of a price chart from Yahoo."""

TIME_HEADER_PARTS = ("date", "time", "datum", "zeit", "year", "fecha")
"""In a table without any value yet, headers that contain one of these are times."""
