"""What the reference says of each public name: numpydoc sections, and an example."""

from __future__ import annotations

import importlib.util
import inspect
import re
from dataclasses import fields, is_dataclass

import pytest

from tests.public_names import members, public_objects

# of numpydoc.validate: what is missing, unknown, in the wrong order or not a sentence
WRONG = {
    *("GL03", "GL05", "GL06", "GL07", "GL08", "SS01", "SS02", "SS03", "SS04", "SS05", "SS06"),
    *("PR01", "PR02", "PR03", "PR04", "PR07", "PR08", "PR09", "RT01", "RT03", "RT04", "RT05"),
    *("YD01", "EX01"),
}
OBJECTS = public_objects()
MEMBERS = {
    f"{name}.{key}": value
    for name, cls in OBJECTS.items()
    if inspect.isclass(cls)
    for key, value in members(cls).items()
}
CALLABLES = OBJECTS | {name: value for name, value in MEMBERS.items() if inspect.isfunction(value)}
PROPERTIES = {name: value for name, value in MEMBERS.items() if name not in CALLABLES}


def sections(text):
    """The headings of a docstring and the lines below each."""
    parts = re.split(r"^ *([A-Z][A-Za-z ]+)\n *-{3,}\n", inspect.cleandoc(text), flags=re.M)
    return dict(zip(["Summary", *parts[1::2]], parts[::2], strict=True))


def described(text, heading):
    """The names that a section of parameters or attributes describes."""
    lines = sections(text).get(heading, "").splitlines()
    heads = [line.partition(" : ")[0] for line in lines if line and not line.startswith(" ")]
    return [name.strip(" *") for head in heads for name in head.split(",")]


@pytest.mark.parametrize("name", CALLABLES)
def test_every_function_class_and_method_has_an_example_that_does_something(name):
    examples = sections(inspect.getdoc(CALLABLES[name]) or "").get("Examples", "")
    assert ">>> " in examples


@pytest.mark.parametrize("name", PROPERTIES)
def test_every_property_is_a_sentence_in_a_line(name):
    first, _, rest = (inspect.getdoc(PROPERTIES[name]) or "").partition("\n")
    assert first.endswith(".")
    assert not rest.partition("\n")[0]


@pytest.mark.parametrize("name", CALLABLES)
def test_every_parameter_is_described_in_order(name):
    value = CALLABLES[name]
    if inspect.isclass(value) and issubclass(value, BaseException):
        return
    text = inspect.getdoc(value)
    if is_dataclass(value):
        wanted = [field.name for field in fields(value) if field.init]
        found = described(text, "Parameters") or described(text, "Attributes")
    else:
        target = value.__init__ if inspect.isclass(value) else value
        wanted = [key for key in inspect.signature(target).parameters if key not in ("self", "cls")]
        found = described(text, "Parameters")
    assert found == wanted


@pytest.mark.parametrize(
    "name", [name for name, value in CALLABLES.items() if not inspect.isclass(value)]
)
def test_what_a_function_returns_is_described_unless_it_is_nothing(name):
    value = CALLABLES[name]
    returns = inspect.signature(value).return_annotation
    found = sections(inspect.getdoc(value))
    assert ("Returns" in found or "Yields" in found) == (returns != "None")


@pytest.mark.parametrize("name", CALLABLES)
def test_numpydoc_finds_nothing_wrong(name):
    if importlib.util.find_spec("numpydoc") is None:
        pytest.skip("needs numpydoc: pip install '.[dev]'")
    from numpydoc.validate import validate

    allowed = set()
    if "Attributes" in sections(inspect.getdoc(CALLABLES[name])):
        allowed = {"PR01"}  # a result: its fields are attributes, as tested above
    place = f"{CALLABLES[name].__module__}.{CALLABLES[name].__qualname__}"
    faults = validate(place)["errors"]
    assert [fault for fault in faults if fault[0] in WRONG - allowed] == []
