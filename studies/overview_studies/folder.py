"""The folder of a study: the page, what it plays, and what each participant does.

Described in docs/explanation/study-format.md.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft

from overview_dsp import build_surface
from overview_dsp.cli.extensions import (
    PROGRAM,
    RATES,
    atomic_folder,
    kind_looks,
    page_with,
    patch_of,
    sound_bytes,
    whole_bytes,
    window_json,
)
from overview_dsp.errors import InputError
from overview_studies.design import NONE, Design
from overview_studies.file_model import Mask
from overview_studies.forms import forms_of
from overview_studies.items import RATE, Item, items_of, samples_sha256
from overview_studies.lists import ListMaker
from overview_studies.static_mapping import static_mapping

MARK = "files.js"
_MARK_HEAD = "self.FILES = "
STUDY = "study.json"
VERSION = 1
CURVE_POINTS = 64
MASK = "mask-48000.wav"
MASK_S = 10
MOST_STIMULI = 2000
SHARED = ("style.css", "icon.svg", "worker.js", "kernel.wasm")
"""Files of the page of a timeline that the page of a study has too, besides imported scripts."""

_QUESTIONS = {
    "identify": "What did you feel?",
    "locate": "Where was it?",
    "count": "How many were there?",
    "compare": "Which was stronger?",
    "draw": "Draw what you felt.",
    "adjust": "Make the second as strong as the first.",
    "staircase": "Which was stronger?",
    "quest": "Which was stronger?",
}


def build_folder(
    design: Design, path: str | Path, progress: Callable[[float], None] | None = None
) -> int:
    """Write a study's folder, whole or not at all; its size in bytes.

    Raises
    ------
    InputError
        The folder can't be written or holds other files; stimuli that can't be made.
    """
    items = items_of(design)
    lists = make_lists(design, items)
    with atomic_folder(path, MARK) as folder:
        listed: dict[str, list[str]] = {"page": [], "more": []}
        digest = hashlib.sha256()
        size = 0
        files = [*page_files().items(), *_forms(design), *_mask(design)]
        for name, data in [*files, *_study_files(design, items, lists, progress)]:
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
            at_first = "/" not in name or name.startswith("jspsych/")
            listed["page" if at_first else "more"].append(name)
            digest.update(name.encode() + data)
            size += len(data)
        known = {"version": digest.hexdigest()[:16], **listed}
        (folder / MARK).write_text(f"{_MARK_HEAD}{json.dumps(known)};\n", encoding="utf-8")
    return size


def page_files() -> dict[str, bytes]:
    """Return the files of the page by their path in the folder of a study."""
    page = Path(__file__).parent / "page"
    found = sorted(path for path in page.rglob("*") if path.is_file())
    own = {path.relative_to(page).as_posix(): path.read_bytes() for path in found}
    return page_with(own, SHARED)


def make_lists(design: Design, items: Sequence[Item]) -> list[dict[str, Any]]:
    """All lists of a design."""
    if len(items) > MOST_STIMULI:
        raise InputError(f"{design.where}: {len(items)} stimuli; a study has up to {MOST_STIMULI}")
    maker = ListMaker(design, items)
    return [maker.make(number) for number in range(1, design.file.participants + 1)]


def played(lists: Sequence[dict[str, Any]]) -> dict[str, set[str]]:
    """The keys that lists play, each with the mappings it is played with."""
    found: dict[str, set[str]] = {}
    for one in lists:
        for step in one["steps"]:
            if "output" in step:
                keys = [*step["stimuli"], *step.get("adjustable", [])]
                if step["type"] == "adaptive":
                    keys.append(step["standard"])
                for key in keys:
                    found.setdefault(key, set()).add(step["output"]["mapping"])
    return found


def _forms(design: Design) -> Iterator[tuple[str, bytes]]:
    for form in forms_of(design).values():
        if "file" in form:
            name = form["file"].rpartition("/")[2]
            source = next(n for n in _asked(design) if n.rpartition("/")[2] == name)
            yield form["file"], (design.where.parent / source).read_bytes()


def _asked(design: Design) -> list[str]:
    asked = design.file.questionnaires
    return [*asked.start, *asked.each, *asked.end]


def _mask(design: Design) -> Iterator[tuple[str, bytes]]:
    if design.file.output.mask is not None:
        noise = masking_noise(design.file.output.mask, design.file.seed)
        yield MASK, sound_bytes(MASK, noise, RATE, "PCM_16")


def masking_noise(mask: Mask, seed: int) -> NDArray[np.float32]:
    """Noise of `MASK_S` that loops without a seam: float32 (frames, 1)."""
    frames = MASK_S * RATE
    hz = np.arange(frames // 2 + 1) / MASK_S
    # nothing below 50 Hz: a tactor's skin would feel it
    height = np.where(hz < 50.0, 0.0, 1.0 / np.sqrt(np.maximum(hz, 1.0)))
    if mask.noise == "white":
        height = (hz >= 50.0).astype(np.float64)
    phase = np.random.Generator(np.random.PCG64(seed)).random(len(hz))
    wave = irfft(height * np.exp(2j * np.pi * phase), frames)
    wave *= 10.0 ** (mask.level_db / 20.0) / np.sqrt(np.mean(np.square(wave)))
    return np.asarray(np.clip(wave, -1.0, 1.0)[:, None], dtype=np.float32)


def _study_files(
    design: Design,
    items: Sequence[Item],
    lists: Sequence[dict[str, Any]],
    progress: Callable[[float], None] | None,
) -> Iterator[tuple[str, bytes]]:
    used = played(lists)
    described: dict[str, Any] = {}
    needed = [item for item in items if item.key in used]
    for number, item in enumerate({item.key: item for item in needed}.values(), 1):
        described[item.key], files = describe(design, item, "static" in used[item.key])
        yield from files.items()
        if progress is not None:
            progress(number / len(used))
    for one in lists:
        yield f"lists/{one['list']:03d}.json", _json(one)
    yield STUDY, _json(study_json(design, lists, described, needed))


def study_json(
    design: Design,
    lists: Sequence[dict[str, Any]],
    stimuli: dict[str, Any],
    items: Sequence[Item],
) -> dict[str, Any]:
    """What holds for all lists."""
    file = design.file
    words: dict[str, str] = {}
    task: dict[str, Any] = {"name": file.task.name, "target": file.task.target}
    if file.task.name == "identify":
        choices = [str(level) for level in design.dimension(file.task.of)]
        choices += [NONE] if file.phases.catch else []
        words = {one: one.replace("_", " ") for one in choices} | {NONE: "nothing"}
        task["choices"] = choices
    task["words"] = {**words, **file.task.words}
    asked = "Did you feel it?" if file.task.method == "yesno" else _QUESTIONS[file.task.name]
    task["question"] = file.task.question or asked
    task |= {key: getattr(file.task, key) for key in ("method", "vary", "standard", "of")}
    looks = [kind_looks(item.timeline, item.preset) for item in items]
    kinds = {kind: look for one in looks for kind, look in one.items() if look["count"]}
    first = items[0].preset
    return {
        "overview_study": VERSION,
        "name": design.name,
        "title": file.title,
        "seed": file.seed,
        "design_sha256": design.sha256,
        "program": PROGRAM,
        "participants": file.participants,
        "lists": len(lists),
        "server": None,
        "text": {"welcome": file.text.welcome, "instructions": file.text.instructions,
                 "end": file.text.end},
        "factors": {
            name: {
                "levels": factor.levels,
                "kind": "between" if factor.between else "within",
                "order": None if factor.between else factor.order,
            }
            for name, factor in file.factors.items()
        },
        "task": task,
        "mask": None
        if file.output.mask is None
        else {"file": MASK, "level_db": file.output.mask.level_db},
        "forms": forms_of(design),
        "exclude": file.exclude.model_dump(),
        "kinds": kinds,
        "full_torque": first.number("tactor.full_torque_mnm") * 1e-3,
        "bare_friction": first.number("surface.friction"),
        "stimuli": stimuli,
    }  # fmt: skip


def describe(design: Design, item: Item, static: bool) -> tuple[dict[str, Any], dict[str, bytes]]:
    """A stimulus for study.json, and its files."""
    at = f"stimuli/{item.key}"
    base = whole_bytes(item.timeline, item.preset, RATE, item.seed, None)
    surface = build_surface(item.timeline, item.preset)
    files = {
        f"{at}.bin": base,
        f"{at}.json": _json(window_json(item.timeline, surface, 0.0)),
    }
    patches, mappings = {}, {}
    static_made = {rate: static_mapping(item, rate) for rate in RATES if static}
    for rate in RATES:
        if rate != RATE:
            patches[str(rate)] = f"{at}-{rate}.patch"
            other = whole_bytes(item.timeline, item.preset, rate, item.seed, None)
            files[f"{at}-{rate}.patch"] = patch_of(base, other)
        if static:
            mappings[str(rate)] = f"{at}-static-{rate}.json"
            files[f"{at}-static-{rate}.json"] = _json(static_made[rate].as_json())
    hand = item.gesture
    vary = design.file.task.vary
    described = {
        "image": f"{at}.bin",
        "patches": patches,
        "drawn": f"{at}.json",
        "static": mappings or None,
        "events": None
        if item.free
        else [
            {"time_s": float(t), "theta2": float(a), "touching": bool(h), "source": "touch"}
            for t, a, h in zip(hand.time_s, hand.theta2, hand.touching, strict=True)
        ],
        "duration_s": None if item.free else hand.duration_s,
        "answer": str(item.names["answer"]),
        "places": item.places(design.file.task.target),
        "curve": item.curve(CURVE_POINTS).round(4).tolist()
        if design.file.task.name == "draw"
        else None,
        "level": item.names.get(vary) if vary is not None else None,
        "timeline": item.names["timeline"],
        "preset": item.names["preset"],
        "gesture": item.names["gesture"],
        "seed": item.seed,
        "parameters": dict(item.parameters),
        "sha256": samples_sha256(item.rendered().samples),
        "static_sha256": samples_sha256(static_made[RATE].render(hand)) if static else None,
    }
    return described, files


def _json(document: dict[str, Any]) -> bytes:
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()


def listed_files(path: str | Path) -> tuple[str, ...]:
    """The files of a folder, as its `MARK` lists them; InputError if it has none."""
    try:
        text = (Path(path) / MARK).read_text(encoding="utf-8")
        known = json.loads(text.removeprefix(_MARK_HEAD).rstrip().rstrip(";"))
        return (*known["page"], *known["more"], MARK)
    except (OSError, ValueError, KeyError) as error:
        raise _no_study(Path(path), error) from None


def _no_study(folder: Path, error: Exception) -> InputError:
    missing = isinstance(error, FileNotFoundError | NotADirectoryError)
    why = f"{MARK} isn't there" if missing else f"{MARK} is broken"
    return InputError(f"{folder}: no study ({why}); `overview study build` makes one")


def read_study(path: str | Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """A folder's study.json and lists.

    Raises
    ------
    InputError
        It isn't a folder that `overview study build` wrote.
    """
    folder = Path(path)
    try:
        study = json.loads((folder / STUDY).read_bytes())
        if study.get("overview_study") != VERSION:
            raise InputError(f"{folder}: {STUDY} is of another version; build it again")
        lists = [
            json.loads((folder / "lists" / f"{number:03d}.json").read_bytes())
            for number in range(1, study["lists"] + 1)
        ]
    except (OSError, ValueError, KeyError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise _no_study(folder, error) from None
    return study, lists
