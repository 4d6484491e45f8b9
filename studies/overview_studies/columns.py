"""Columns of the tables of answers."""

COLUMN_DESCRIPTIONS = {
    "participant": "code of the participant",
    "session": "identifier of the session",
    "list": "number of the list that the session followed",
    "complete": "whether the session was finished (1) or not (0)",
    "position": "index of the answer in its session, from 1",
    "trial": "identifier of the trial in its list",
    "phase": "practice, main, catch or attention",
    "block": "condition block, from 1",
    "repeat": "which repetition of all stimuli within the block, from 1",
    "task": "task of the trial",
    "stimulus": "key of the stimulus; a comparison has two keys, separated by a space",
    "stimulus_sha256": "SHA-256 of the samples of the stimulus",
    "seed": "seed of the stimulus",
    "timeline": "timeline of the stimulus",
    "preset": "preset of the stimulus",
    "gesture": "gesture of the stimulus; free: the participant moves",
    "level": "value of the varied dimension",
    "correct_response": "the correct answer; JSON unless it is a single value",
    "response": "the answer; JSON unless it is a single value",
    "correct": "1 correct, 0 wrong, empty where the task has no correct answer",
    "error": "signed difference from the correct answer",
    "time_s": "time from the first touch to the end of the movement, s",
    "path": "length of the movement, in timelines",
    "returns": "how often the movement came back to the place",
    "rt_ms": "time from the first possible answer to the answer, ms",
    "presentations": "number of presentations of the stimulus",
    "source": "input that moved the disk: touch, twist or keys",
    "simulated": "SIMULATED: no person gave this answer",
    "started_utc": "start of the trial by the page's clock, ISO 8601",
    "received_utc": "time when the answer was stored, ISO 8601",
    "sample_rate": "sample rate of the page's audio, Hz",
    "output_latency_ms": "output latency of the page's audio as reported by the browser, ms",
    "user_agent": "browser",
    "take_events": "number of control events in the takes",
    "design_sha256": "SHA-256 of the study's file",
    "program": "version of overview-dsp and digest of its kernels",
}
"""Description of each column of the table of trials, besides factors."""

RESERVED_COLUMNS = {*COLUMN_DESCRIPTIONS, "measure", "unit", "value", "reason", "form", "item"}
"""Columns of all tables, which no factor of conditions may have as a name."""
