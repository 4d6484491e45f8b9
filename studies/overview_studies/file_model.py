"""Keys of a study's TOML file: types, ranges and defaults.

`design` checks the rules that involve more than one key.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

TASKS = (
    "identify", "locate", "search", "count", "compare", "draw", "adjust", "staircase", "quest",
)  # fmt: skip
CHANNELS = ("click", "tactor", "both", "visual", "all")
MAPPINGS = ("friction", "static")
INPUTS = ("touch", "twist", "keys", "any")

Level = str | float
Gain = Annotated[float, Field(ge=-60.0, le=24.0)]
Whole = Annotated[int, Field(ge=1, le=1000)]


class _Strict(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False
    )


class Factor(_Strict):
    """Factor with its levels, within or between participants."""

    within: list[Level] | None = Field(None, min_length=2, max_length=12)
    between: list[Level] | None = Field(None, min_length=2, max_length=12)
    order: Literal["williams", "full", "blocks"] = "blocks"

    @property
    def levels(self) -> list[Level]:
        """Levels of the factor."""
        return self.within or self.between or []


class SyntheticTimelines(_Strict):
    """Timelines generated for the study, with events of one kind or with curves."""

    kinds: list[str] = Field(default_factory=list, max_length=24)
    curves: list[Literal["rise", "fall", "peak", "dip", "wave", "steady"]] = Field(
        default_factory=list
    )
    counts: list[Annotated[int, Field(ge=1, le=12)]] = Field([1], min_length=1)
    variants: Annotated[int, Field(ge=1, le=200)] = 1
    positions: list[float] = Field([0.15, 0.85], min_length=2, max_length=2)
    crowd: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    duration_s: Annotated[float, Field(ge=1.0, le=1e7)] = 5400.0


class Task(_Strict):
    """Task of the participants."""

    name: Literal[
        "identify", "locate", "search", "count", "compare", "draw", "adjust", "staircase", "quest"
    ]
    question: str | None = None
    of: str = "answer"
    target: str | None = None
    labels: dict[str, str] = Field(default_factory=dict)
    vary: str | None = None
    standard: Level | None = None
    scale: Literal["linear", "log", "dB"] | None = None
    method: Literal["2afc", "yesno"] = "2afc"
    max_trials: Annotated[int, Field(ge=1, le=999)] = 60
    down: Annotated[int, Field(ge=1, le=5)] = 2
    reversals: Annotated[int, Field(ge=2, le=50)] = 8
    steps: list[Whole] = Field([2, 1], min_length=1)


class Practice(_Strict):
    """Practice trials, which are never analysed."""

    repeats: Whole = 1
    feedback: bool = True
    criterion: Annotated[float, Field(ge=0.0, le=1.0)] | None = None


class Training(_Strict):
    """Lesson about the kinds before the first block, with ten questions (`lesson`)."""

    lesson: Literal[True] = True
    criterion: Annotated[int, Field(ge=1, le=10)] | None = None
    most_rounds: Annotated[int, Field(ge=1, le=3)] = 3


class Main(_Strict):
    """Main trials, which are analysed."""

    repeats: Whole = 1
    feedback: bool = False


class Phases(_Strict):
    """Trials of one condition block."""

    practice: Practice | None = None
    main: Main = Main()
    catch: Annotated[float, Field(ge=0.0, le=0.8)] = 0.0
    attention: Annotated[int, Field(ge=0, le=20)] = 0


class Mask(_Strict):
    """Masking noise on the audio channel."""

    noise: Literal["pink", "white"] = "pink"
    level_db: Annotated[float, Field(ge=-80.0, le=-10.0)] = -30.0


class Output(_Strict):
    """Defaults for sound, vibration and picture, which factors may override."""

    channel: Literal["click", "tactor", "both", "visual", "all"] = "both"
    mapping: Literal["friction", "static"] = "friction"
    input: Literal["touch", "twist", "keys", "any"] = "any"
    click_db: Gain = 0.0
    tactor_db: Gain = 0.0
    mask: Mask | None = None


class Consent(_Strict):
    """Consent text; its version is stored with the answer."""

    version: str
    text: str


class Questionnaires(_Strict):
    """Questionnaires: tlx, comments, consent, or HTML files."""

    start: list[str] = Field(default_factory=list)
    each: list[str] = Field(default_factory=list)
    end: list[str] = Field(default_factory=list)
    consent: Consent | None = None


class Exclude(_Strict):
    """Exclusion rules, defined before data collection."""

    incomplete: bool = True
    attention: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0


class Power(_Strict):
    """Effect that the study should detect, which `overview study check` simulates."""

    effect: Annotated[float, Field(gt=0.0, le=5.0)]
    share: Annotated[float, Field(ge=0.1, le=0.99)] = 0.8


class Text(_Strict):
    """Texts of the page; instructions that are left out fit the task and its gestures."""

    welcome: str = "Welcome. Please use headphones or hold the actuator as you were shown."
    instructions: str | None = None
    end: str = "The study is complete. Thank you."
    conditions: dict[str, str] = Field(default_factory=dict)


class StudyFile(_Strict):
    """All keys of a study file."""

    title: str = Field(min_length=1, max_length=200)
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9]([A-Za-z0-9-]{0,62}[A-Za-z0-9])?$")] | None = (
        None
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    participants: Annotated[int, Field(ge=1, le=999)]
    factors: dict[str, Factor] = Field(default_factory=dict)
    task: Task
    stimuli: dict[str, Any]
    training: Training | None = None
    phases: Phases = Phases()
    output: Output = Output()
    questionnaires: Questionnaires = Questionnaires()
    exclude: Exclude = Exclude()
    power: Power | None = None
    text: Text = Text()
