"""Folder of a study: the page, its stimuli and one list per participant.

The format is described in docs/explanation/study-format.md.
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
    kind_styles,
    make_patch,
    other_page_files,
    sound_bytes,
    whole_bytes,
    window_json,
)
from overview_dsp.errors import InputError
from overview_studies.design import FREE, NONE, Design
from overview_studies.file_model import Mask
from overview_studies.forms import forms_of
from overview_studies.lists import ListMaker
from overview_studies.scales import scale_kind
from overview_studies.static_mapping import static_mapping
from overview_studies.stimuli import RATE, Stimulus, samples_sha256, stimuli_of

MANIFEST = "files.js"
_MANIFEST_HEAD = "self.FILES = "
STUDY = "study.json"
VERSION = 1
CURVE_POINTS = 64
MASK = "mask-48000.wav"
MASK_S = 10
MAX_STIMULI = 2000
SHARED = ("style.css", "icon.svg", "worker.js", "kernel.wasm")
"""Files shared with the page of a timeline, besides imported scripts."""

_QUESTIONS = {
    "identify": "What did you feel?",
    "locate": "Where was it?",
    "search": "Go back to the place you are asked for.",
    "count": "How many were there?",
    "compare": "Which was stronger?",
    "draw": "Draw what you felt.",
    "adjust": "Make the second as strong as the first.",
    "staircase": "Which was stronger?",
    "quest": "Which was stronger?",
}

_TO_DO = {
    "identify": "Then choose what it was.",
    "locate": "Then say where it was.",
    "search": "Browse all of it, then return to the place in question and stop there.",
    "count": "Then say how many there were.",
    "compare": "There are two, one after the other. Then choose one of them.",
    "draw": "Then draw the curve from its start to its end.",
    "adjust": "There are two. Change the second until it is as strong as the first.",
    "staircase": "There are two, one after the other. Then choose one of them.",
    "quest": "There are two, one after the other. Then choose one of them.",
}


def instructions_of(design: Design) -> str:
    """Return the instructions of a study: its own, or those that fit its task and gestures."""
    task, free = design.file.task, FREE in design.grid.gestures
    move = "Move along the field, forwards and backwards, as often as you like. " if free else (
        "Press Play, as often as you like. ")  # fmt: skip
    to_do = "Then say whether you felt it." if task.method == "yesno" else _TO_DO[task.name]
    default = f"{move}Attend to what you feel and hear. {to_do}"
    return design.file.text.instructions or _by_sense(design, default)


def _by_sense(design: Design, text: str) -> str:
    """Return a text with the senses that the channels of the study address."""
    factor = design.file.factors.get("channel")
    channels = set(factor.levels if factor else [design.file.output.channel])
    if channels == {"visual"}:
        text = text.replace("feel and hear", "see").replace("feel", "see").replace("felt", "saw")
    elif channels & {"visual", "all"}:
        text = text.replace("feel and hear", "see, feel and hear")
    return text


def build_folder(
    design: Design, path: str | Path, progress: Callable[[float], None] | None = None
) -> int:
    """Write a study's folder atomically; return its size in bytes.

    Raises
    ------
    InputError
        The folder cannot be written or contains other files, or a stimulus cannot be rendered.
    """
    items = stimuli_of(design)
    lists = make_lists(design, items)
    with atomic_folder(path, MANIFEST) as folder:
        listed: dict[str, list[str]] = {"page": [], "more": []}
        digest = hashlib.sha256()
        size = 0
        files = [*page_files().items(), *_form_files(design), *_mask_files(design)]
        for name, data in [*files, *_study_files(design, items, lists, progress)]:
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
            is_page = "/" not in name or name.startswith("jspsych/")
            listed["page" if is_page else "more"].append(name)
            digest.update(name.encode() + data)
            size += len(data)
        known = {"version": digest.hexdigest()[:16], **listed}
        (folder / MANIFEST).write_text(f"{_MANIFEST_HEAD}{json.dumps(known)};\n", encoding="utf-8")
    return size


def page_files() -> dict[str, bytes]:
    """Return the files of the page by their path in the folder of a study."""
    page = Path(__file__).parent / "page"
    found = sorted(path for path in page.rglob("*") if path.is_file())
    own = {path.relative_to(page).as_posix(): path.read_bytes() for path in found}
    return other_page_files(own, SHARED)


def make_lists(design: Design, items: Sequence[Stimulus]) -> list[dict[str, Any]]:
    """Return all lists of a design."""
    if len(items) > MAX_STIMULI:
        raise InputError(f"{design.path}: {len(items)} stimuli; must be at most {MAX_STIMULI}")
    maker = ListMaker(design, items)
    return [maker.make(number) for number in range(1, design.file.participants + 1)]


def presented_stimuli(lists: Sequence[dict[str, Any]]) -> dict[str, set[str]]:
    """Return the stimulus keys that the lists present, with the mappings of each."""
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


def _form_files(design: Design) -> Iterator[tuple[str, bytes]]:
    for form in forms_of(design).values():
        if "file" in form:
            name = form["file"].rpartition("/")[2]
            source = next(n for n in _form_names(design) if n.rpartition("/")[2] == name)
            yield form["file"], (design.path.parent / source).read_bytes()


def _form_names(design: Design) -> list[str]:
    forms = design.file.questionnaires
    return [*forms.start, *forms.each, *forms.end]


def _mask_files(design: Design) -> Iterator[tuple[str, bytes]]:
    if design.file.output.mask is not None:
        noise = masking_noise(design.file.output.mask, design.file.seed)
        yield MASK, sound_bytes(MASK, noise, RATE, "PCM_16")


def masking_noise(mask: Mask, seed: int) -> NDArray[np.float32]:
    """Return noise of `MASK_S` that loops without a discontinuity: float32 (frames, 1)."""
    frames = MASK_S * RATE
    hz = np.arange(frames // 2 + 1) / MASK_S
    # no energy below 50 Hz, which could be felt through the skin
    height = np.where(hz < 50.0, 0.0, 1.0 / np.sqrt(np.maximum(hz, 1.0)))
    if mask.noise == "white":
        height = (hz >= 50.0).astype(np.float64)
    phase = np.random.Generator(np.random.PCG64(seed)).random(len(hz))
    wave = irfft(height * np.exp(2j * np.pi * phase), frames)
    wave *= 10.0 ** (mask.level_db / 20.0) / np.sqrt(np.mean(np.square(wave)))
    return np.asarray(np.clip(wave, -1.0, 1.0)[:, None], dtype=np.float32)


def _study_files(
    design: Design,
    items: Sequence[Stimulus],
    lists: Sequence[dict[str, Any]],
    progress: Callable[[float], None] | None,
) -> Iterator[tuple[str, bytes]]:
    used = presented_stimuli(lists)
    described: dict[str, Any] = {}
    needed = [item for item in items if item.key in used]
    for number, item in enumerate({item.key: item for item in needed}.values(), 1):
        described[item.key], files = describe_stimulus(design, item, "static" in used[item.key])
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
    items: Sequence[Stimulus],
) -> dict[str, Any]:
    """Return the content of study.json, which applies to all lists."""
    file = design.file
    words: dict[str, str] = {}
    task: dict[str, Any] = {"name": file.task.name, "target": file.task.target}
    if file.task.name == "identify":
        choices = [str(level) for level in design.dimension(file.task.of)]
        choices += [NONE] if file.phases.catch else []
        words = {one: one.replace("_", " ") for one in choices} | {NONE: "nothing"}
        task["choices"] = choices
    if file.task.method == "yesno":
        words = {"1": _by_sense(design, "I felt it"), "0": _by_sense(design, "I felt nothing")}
    task["words"] = {**words, **file.task.labels}
    question = "Did you feel it?" if file.task.method == "yesno" else _QUESTIONS[file.task.name]
    task["question"] = file.task.question or _by_sense(design, question)
    task |= {key: getattr(file.task, key) for key in ("method", "vary", "standard", "of")}
    if file.task.vary is not None:
        task["scale"] = scale_kind(
            file.task.vary, design.dimension(file.task.vary), file.task.scale
        )
    styles = [kind_styles(item.timeline, item.preset) for item in items]
    kinds = {kind: style for one in styles for kind, style in one.items() if style["count"]}
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
        "text": {"welcome": file.text.welcome, "instructions": instructions_of(design),
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
        "full_torque": first.number("tactor.reference_torque_mnm") * 1e-3,
        "bare_friction": first.number("surface.friction"),
        "stimuli": stimuli,
    }  # fmt: skip


def draft_study(design: Design) -> tuple[dict[str, Any], dict[int, dict[str, Any]]]:
    """Return study.json without rendered sounds, and the lists by number: for observers."""
    items = stimuli_of(design)
    lists = make_lists(design, items)
    no_sound = {"static": None, "sha256": "", "static_sha256": None}
    entries = {item.key: {**stimulus_entry(design, item), **no_sound}
               for item in items}  # fmt: skip
    return study_json(design, lists, entries, items), {one["list"]: one for one in lists}


def stimulus_entry(design: Design, item: Stimulus) -> dict[str, Any]:
    """Return the part of a stimulus's entry in study.json that needs no sound."""
    gesture, vary = item.gesture, design.file.task.vary
    return {
        "events": None
        if item.free
        else [
            {"time_s": float(t), "theta2": float(a), "touching": bool(h), "source": "touch"}
            for t, a, h in zip(gesture.time_s, gesture.theta2, gesture.touching, strict=True)
        ],
        "duration_s": None if item.free else gesture.duration_s,
        "answer": str(item.names["answer"]),
        "places": item.positions(design.file.task.target),
        "curve": item.curve(CURVE_POINTS).round(4).tolist()
        if design.file.task.name == "draw"
        else None,
        "level": item.names.get(vary) if vary is not None else None,
        "timeline": item.names["timeline"],
        "preset": item.names["preset"],
        "gesture": item.names["gesture"],
        "seed": item.seed,
        "parameters": dict(item.parameters),
    }


def describe_stimulus(
    design: Design, item: Stimulus, static: bool
) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the entry of a stimulus for study.json, and its files."""
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
            files[f"{at}-{rate}.patch"] = make_patch(base, other)
        if static:
            mappings[str(rate)] = f"{at}-static-{rate}.json"
            files[f"{at}-static-{rate}.json"] = _json(static_made[rate].as_json())
    described = {
        "image": f"{at}.bin",
        "patches": patches,
        "drawn": f"{at}.json",
        "static": mappings or None,
        **stimulus_entry(design, item),
        "sha256": samples_sha256(item.render_stimulus().samples),
        "static_sha256": samples_sha256(static_made[RATE].render(item.gesture)) if static else None,
    }
    return described, files


def _json(document: dict[str, Any]) -> bytes:
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()


def listed_files(path: str | Path) -> tuple[str, ...]:
    """Return the files of a folder that its `MANIFEST` lists.

    Raises
    ------
    InputError
        The folder has no valid manifest.
    """
    try:
        text = (Path(path) / MANIFEST).read_text(encoding="utf-8")
        known = json.loads(text.removeprefix(_MANIFEST_HEAD).rstrip().rstrip(";"))
        return (*known["page"], *known["more"], MANIFEST)
    except (OSError, ValueError, KeyError) as error:
        raise _not_a_study(Path(path), error) from None


def _not_a_study(folder: Path, error: Exception) -> InputError:
    missing = isinstance(error, FileNotFoundError | NotADirectoryError)
    why = f"{MANIFEST} is missing" if missing else f"{MANIFEST} is not valid"
    return InputError(f"{folder}: no study ({why}); create it with `overview study build`")


def read_study(path: str | Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return a folder's study.json and lists.

    Raises
    ------
    InputError
        `overview study build` did not write the folder.
    """
    folder = Path(path)
    try:
        study = json.loads((folder / STUDY).read_bytes())
        if study.get("overview_study") != VERSION:
            raise InputError(f"{folder}: {STUDY} has an unsupported version; build the study again")
        lists = [
            json.loads((folder / "lists" / f"{number:03d}.json").read_bytes())
            for number in range(1, study["lists"] + 1)
        ]
    except (OSError, ValueError, KeyError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise _not_a_study(folder, error) from None
    return study, lists
