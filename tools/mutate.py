"""Whether the tests see the code go wrong: each small change to it must fail one of them.

python tools/mutate.py [part ...] [--sample N] [--children N] [--keep FOLDER]

It needs `pip install "mutmut>=3.8,<4"`. `mutation.toml` lists the modules that are changed, the
tests of each, and the lines that hold words only. A change that no test fails is a survivor. It is
an error if fewer of a part's changes fail a test than its `killed_at_least` (90 % where it has
none). Of a part with `explained = true`, `surviving_mutants.toml` gives the reason of every
survivor: one without a reason is an error, and a reason that fits no survivor is listed.
`--sample N` tries N changes of each part, drawn at random with a seed that is printed.

mutmut switches changes on and off inside one process and forks it for each, so that imports and
compiled kernels are shared; but it leaves functions with decorators alone. Modules are therefore
changed in a copy, whose decorators are assignments. Kernels run as plain Python.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
COPIED = ("overview_dsp", "presets", "actuators", "sensors", "tests", "pyproject.toml")
KILLED_AT_LEAST = 0.9
CACHE = re.compile(r"(functools\.)?(lru_)?cache\b")
SURVIVED = {0, 5, 33}  # exit codes: all tests passed, or none runs there

# a failing example needn't be made small, and no run may learn from another
CONFTEST = """
from hypothesis import Phase, settings

phases = [Phase.explicit, Phase.generate]
settings.register_profile(
    "mutation", deadline=None, database=None, derandomize=True, phases=phases, max_examples=50
)
"""


def decorators_as_assignments(source: str) -> str:
    """The same module; a cache is dropped, since it would hide changes from later calls."""
    lines = source.splitlines()
    functions = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)]
    for function in sorted(functions, key=lambda node: -node.lineno):
        names = [ast.unparse(decorator) for decorator in function.decorator_list]
        if not names or names == ["classmethod"]:
            continue
        indent = " " * function.col_offset
        kept = [name for name in names if not CACHE.match(name)]
        value = function.name
        before = ""
        for name in reversed(kept):
            if name == f"{function.name}.setter":  # by then the name is the new function's
                before = f"{indent}_its_{function.name} = {function.name}"
                name = f"_its_{name}"
            value = f"{name}({value})"
        if kept:
            lines.insert(function.end_lineno, f"{indent}{function.name} = {value}")
        for decorator in function.decorator_list:
            lines[decorator.lineno - 1 : decorator.end_lineno] = [before]
            before = ""
    return "\n".join(lines) + "\n"


def matched(pattern: str) -> list[str]:
    """The modules of a pattern of `mutation.toml`, in order."""
    found = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(pattern))
    return [name for name in found if not name.endswith("__init__.py")] or [pattern]


def prepare(work: Path, part: dict, ignored: list[str]) -> None:
    """A copy of the project whose modules of one part mutmut will change."""
    for name in COPIED:
        # with its times, by which numba knows a compiled kernel's source
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, work / name, dirs_exist_ok=True)
        else:
            shutil.copy2(ROOT / name, work / name)
    shutil.rmtree(work / "mutants", ignore_errors=True)
    (work / "conftest.py").write_text(CONFTEST)
    for module in part["modules"]:
        source = (ROOT / module).read_text()
        (work / module).write_text(decorators_as_assignments(source))
    settings = {
        "source_paths": sorted({str(Path(module).parent) for module in part["modules"]}),
        "only_mutate": part["modules"],
        "also_copy": [*COPIED[:-2], "conftest.py"],
        "do_not_mutate_patterns": ignored,
        "pytest_add_cli_args": [
            *("-n0", "-pno:cacheprovider", "--hypothesis-profile=mutation"),
            # numpy warns where interpreted kernels' integers wrap around as they should
            *(["-Wignore::RuntimeWarning"] if part.get("interpreted") else []),
        ],
        "pytest_add_cli_args_test_selection": part["tests"],
        # of the tests' own time, and 5 s: a change may loop for ever
        "timeout_multiplier": 5.0,
        "timeout_constant": 5.0,
        "use_git_change_detection": False,
        "track_dependencies": False,
    }
    text = (ROOT / "pyproject.toml").read_text() + "\n[tool.mutmut]\n"
    # JSON's strings, lists and booleans are TOML's too
    text += "".join(f"{key} = {json.dumps(value)}\n" for key, value in settings.items())
    (work / "pyproject.toml").write_text(text)


# what `mutmut run` does before it runs a test
GENERATE = """
import pathlib
from mutmut import __main__ as mutmut
mutmut.set_mutant_under_test("mutant_generation")
pathlib.Path("mutants").mkdir(exist_ok=True)
mutmut.copy_src_dir()
mutmut.copy_also_copy_files()
mutmut.setup_source_paths()
mutmut.store_lines_covered_by_tests()
mutmut.create_mutants(1)
"""


def drawn(work: Path, part: dict, count: int, seed: int) -> list[str]:
    """Names of `count` changes of a part, drawn at random; all, if there are no more."""
    subprocess.run([sys.executable, "-c", GENERATE], cwd=work, check=True, capture_output=True)
    names: list[str] = []
    for module in part["modules"]:
        meta = work / "mutants" / f"{module}.meta"
        names += sorted(json.loads(meta.read_text())["exit_code_by_key"]) if meta.exists() else []
    return random.Random(seed).sample(names, min(count, len(names)))


def run(work: Path, part: dict, children: int, names: list[str]) -> dict[str, int]:
    """Exit code of the tests under each change; of the changes in `names`, if there are any."""
    environment = {**os.environ, "PYTHONPATH": "", "PYTHONDONTWRITEBYTECODE": "1"}
    if part.get("interpreted"):
        environment["NUMBA_DISABLE_JIT"] = "1"
    mutmut = Path(sys.executable).with_name("mutmut")
    with (work / "mutmut.log").open("w") as log:
        done = subprocess.run(
            [mutmut, "run", "--max-children", str(children), *names],
            cwd=work,
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    if done.returncode:
        sys.exit((work / "mutmut.log").read_text()[-4000:])
    codes: dict[str, int] = {}
    for module in part["modules"]:
        meta = work / "mutants" / f"{module}.meta"  # none where there is nothing to change
        codes |= json.loads(meta.read_text())["exit_code_by_key"] if meta.exists() else {}
    codes = {name: code for name, code in codes.items() if not names or name in names}
    if None in codes.values():
        sys.exit(f"{part['name']}: mutmut left changes untried; see {work}/mutmut.log")
    return codes


def module_and_function(name: str) -> tuple[str, str]:
    """Return module and function of a mutant such as a.b.xǁClassǁmethod__mutmut_3."""
    module, _, mangled = name.partition("__mutmut_")[0].rpartition(".")
    function = mangled[1:].strip("ǁ").replace("ǁ", ".") if "ǁ" in mangled else mangled[2:]
    return module.replace(".", "/") + ".py", function


def described(work: Path, name: str) -> tuple[str, str, str, str]:
    """A mutant as `surviving_mutants.toml` has it: module, function, what stood, what stands."""
    mutmut = Path(sys.executable).with_name("mutmut")
    shown = subprocess.run(
        [mutmut, "show", name], cwd=work, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    was, now = (
        " ".join(line[1:].strip() for line in shown if line[:1] == sign and line[:3] != 3 * sign)
        for sign in "-+"
    )
    return *module_and_function(name), was, now


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", help="names of parts; all, if none is named")
    parser.add_argument(
        "--sample", type=int, default=0, metavar="N", help="number of mutants per part"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample")
    parser.add_argument("--children", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="work there, and leave it")
    asked = parser.parse_args()
    plan = tomllib.loads((ROOT / "tools/mutation.toml").read_text())
    known = tomllib.loads((ROOT / "tools/surviving_mutants.toml").read_text()).get("mutant", [])
    explained = Counter((one["module"], one["function"], one["was"], one["now"]) for one in known)
    names = [part["name"] for part in plan["part"]]
    if unknown := [name for name in asked.parts if name not in names]:
        parser.error(f"no part is called {unknown[0]}; there are {', '.join(names)}")
    parts = [part for part in plan["part"] if not asked.parts or part["name"] in asked.parts]
    for part in parts:
        part["modules"] = [name for pattern in part["modules"] for name in matched(pattern)]
    work = asked.keep or Path(tempfile.mkdtemp())
    failed = False
    print(f"{'part':28} {'mutants':>7} {'killed':>7} {'survive':>7} {'unexplained':>11} {'min':>5}")
    total: Counter[str] = Counter()
    try:
        for part in parts:
            began = time.monotonic()
            prepare(work, part, plan["not_mutated"])
            some = drawn(work, part, asked.sample, asked.seed) if asked.sample else []
            codes = run(work, part, asked.children, some)
            found = Counter(
                described(work, name) for name, code in codes.items() if code in SURVIVED
            )
            expected = Counter(
                {key: n for key, n in explained.items() if key[0] in part["modules"]}
            )
            new, gone = found - expected, expected - found
            if asked.sample:
                gone = Counter()
            count = {
                "mutants": len(codes),
                "killed": len(codes) - found.total(),
                "survive": found.total(),
                "unexplained": new.total(),
            }
            total.update(count)
            minutes = (time.monotonic() - began) / 60.0
            print(
                f"{part['name']:28} {count['mutants']:7} {count['killed']:7} "
                f"{count['survive']:7} {count['unexplained']:11} {minutes:5.1f}",
                flush=True,
            )
            for title, these in (("no test fails", new), ("explained, but no survivor", gone)):
                for module, function, was, now in sorted(these.elements()):
                    print(f"  {title}: {module} {function}\n    - {was}\n    + {now}", flush=True)
            least = part.get("killed_at_least", KILLED_AT_LEAST)
            failed |= bool(new) and part.get("explained", False)
            failed |= count["killed"] < least * count["mutants"]
    finally:
        if not asked.keep:
            shutil.rmtree(work)
    print(f"{'all':28} {total['mutants']:7} {total['killed']:7} {total['survive']:7}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
