"""Translator from LLVM IR to C99, for the subset that the kernels use.

Every value is a variable and every block a label. Loads and stores go through memcpy, so that
neither aliasing nor alignment matters. Arithmetic is translated operation by operation, and
`operations.h` prevents the compiler from fusing it. Unknown instructions are errors.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

C_TYPES = {
    "i1": "uint8_t",
    "i8": "uint8_t",
    "i32": "uint32_t",
    "i64": "uint64_t",
    "double": "double",
    "float": "float",
    "ptr": "unsigned char *",
    "<8 x double>": "ov_lanes",
    "void": "void",
}
SIGNED = {"i8": "int8_t", "i32": "int32_t", "i64": "int64_t"}
SIZES = {"i1": 1, "i8": 1, "i32": 4, "i64": 8, "double": 8, "float": 4, "ptr": 0}
ACCESS = {"i1": "b", "i8": "b", "i32": "i", "i64": "l", "double": "d", "float": "f", "ptr": "p"}
ACCESS["<8 x double>"] = "v"
OPERATORS = {
    "fadd": "+", "fsub": "-", "fmul": "*", "fdiv": "/", "add": "+", "sub": "-", "mul": "*",
    "and": "&", "or": "|", "xor": "^", "shl": "<<", "lshr": ">>",
}  # fmt: skip
SIGNED_OPERATORS = {"sdiv": "/", "srem": "%", "ashr": ">>"}
LANES = {"fadd": "add", "fsub": "sub", "fmul": "mul"}
ORDERED = {"oeq": "==", "ogt": ">", "oge": ">=", "olt": "<", "ole": "<=", "une": "!="}
# unordered: true where the ordered opposite is false
UNORDERED = {"ueq": "one", "ugt": "ole", "uge": "olt", "ult": "oge", "ule": "ogt"}
COMPARES = {"eq": "==", "ne": "!=", "gt": ">", "ge": ">=", "lt": "<", "le": "<="}
CALLS = {
    "llvm.fabs.f64": "fabs", "llvm.sqrt.f64": "sqrt", "sqrt": "sqrt",
    "llvm.smax.i64": "ov_smax", "llvm.smin.i64": "ov_smin",
    "llvm.umax.i64": "ov_umax", "llvm.umin.i64": "ov_umin", "llvm.smax.i32": "ov_smax32",
}  # fmt: skip
SKIPPED = ("llvm.assume", "llvm.lifetime", "llvm.experimental.noalias")
FLAGS = (
    r"(?:(?:nuw|nsw|exact|disjoint|nneg|samesign|inbounds|nusw|fast|nnan|ninf|nsz|tail|notail)\s+)*"
)
NAME = r'%(?:"[^"]+"|[\w.$-]+)'
TYPE = r"(?:<8 x double>|\w+)"

HEAD = '#include "operations.h"\n'


def split(text: str) -> list[str]:
    """Split a text at commas outside brackets."""
    parts, depth, start = [], 0, 0
    for i, letter in enumerate(text):
        depth += (letter in "([{<") - (letter in ")]}>")
        if letter == "," and depth == 0:
            parts.append(text[start:i].strip())
            start = i + 1
    parts.append(text[start:].strip())
    return [part for part in parts if part]


def typed(text: str) -> tuple[str, str]:
    """Return type and value of an operand, without attributes."""
    kind = re.match(TYPE, text)
    if not kind:
        raise ValueError(f"no operand: {text}")
    rest = text[kind.end() :].strip()
    if "getelementptr" in rest:
        return kind[0], rest[rest.index("getelementptr") :]
    return kind[0], rest.split()[-1]


def bare(name: str) -> str:
    """Return the name of a block from a jump's operand."""
    return name[1:].strip('"')


class Function:
    """Translation of one function."""

    def __init__(self, text: str, names: dict[str, str]) -> None:
        self.names = names  # of functions and constants
        self.variables: dict[str, tuple[str, str]] = {}  # IR name: C name and IR type
        self.labels: dict[str, str] = {}
        self.rooms: list[int] = []  # bytes of each place on the stack
        lines = text.splitlines()
        head = re.match(r"define .*?(\w+|<8 x double>) @([\w.]+)\((.*)\)[^()]*\{$", lines[0])
        if not head:
            raise ValueError(f"no function: {lines[0]}")
        self.result, self.name = head[1], head[2]
        self.parameters = [self.declare(*reversed(typed(part))) for part in split(head[3])]
        self.blocks = self.read(lines[1:-1])

    def declare(self, name: str, kind: str) -> str:
        if name not in self.variables:
            self.variables[name] = (f"v{len(self.variables)}", kind)
        return self.variables[name][0]

    def read(self, lines: list[str]) -> list[tuple[str, list[str]]]:
        blocks: list[tuple[str, list[str]]] = []
        joined: list[str] = []
        for line in lines:
            line = re.sub(r"(, ![\w.]+ !\d+)+|,? ?#\d+$|\s*;.*$", "", line).rstrip()
            if not line:
                continue
            if joined and joined[-1].count("[") > joined[-1].count("]"):
                joined[-1] += " " + line.strip()
            else:
                joined.append(line)
        for line in joined:
            label = re.match(r'("?[\w.$-]+"?):$', line)
            if label:
                blocks.append((label[1].strip('"'), []))
            elif not blocks:
                # the entry's label is not written, but counts after unnamed parameters
                unnamed = sum(name[1:].isdigit() for name in self.variables)
                blocks.append((str(unnamed), [line.strip()]))
            else:
                blocks[-1][1].append(line.strip())
        self.labels = {label: f"L{i}" for i, (label, _) in enumerate(blocks)}
        return blocks

    # --- operands ------------------------------------------------------------------------------

    def value(self, kind: str, text: str) -> str:
        if text.startswith("%"):
            return self.variables[text][0]
        if text.startswith("@"):
            return f"(unsigned char *){self.names[text[1:]]}"
        if text.startswith("getelementptr"):
            inside = split(text[text.index("(") + 1 : text.rindex(")")])
            base = self.value(*typed(inside[1]))
            return self.address(inside[0].split()[-1], base, *typed(inside[2]))
        if text in ("poison", "undef", "null", "zeroinitializer"):
            return "0" if kind != "ptr" else "(unsigned char *)0"
        if kind in ("double", "float"):
            return literal(text)
        if text in ("true", "false"):
            return str(int(text == "true"))
        return f"UINT64_C({int(text) % 2**64})" if kind == "i64" else f"{int(text) % 2**32}u"

    def address(self, kind: str, base: str, index_kind: str, index: str) -> str:
        if kind not in SIZES or kind == "ptr":
            raise ValueError(f"an address in units of {kind}")
        if re.fullmatch(r"-?\d+", index):
            return f"{base} + (intptr_t){int(index) * SIZES[kind]}"
        number = f"(intptr_t)({SIGNED[index_kind]}){self.value(index_kind, index)}"
        return f"{base} + {number} * {SIZES[kind]}"

    # --- statements ------------------------------------------------------------------------------

    def jump(self, from_: str, to: str) -> str:
        """Yield a jump to a block, after assigning its phis in parallel."""
        copies = []
        for line in dict(self.blocks)[to]:
            phi = re.match(rf"({NAME}) = phi ({TYPE}) (.*)", line)
            if not phi:
                break
            for pair in split(phi[3]):
                text, origin = split(pair[1:-1])
                if bare(origin) == from_:
                    target = self.variables[phi[1]][0]
                    if text not in ("poison", "undef"):
                        copies.append((C_TYPES[phi[2]], target, self.value(phi[2], text)))
        goto = f"goto {self.labels[to]};"
        if not copies:
            return goto
        if len(copies) == 1:
            return f"{{ {copies[0][1]} = {copies[0][2]}; {goto} }}"
        first = " ".join(f"{kind} t{i} = {text};" for i, (kind, _, text) in enumerate(copies))
        then = " ".join(f"{name} = t{i};" for i, (_, name, _) in enumerate(copies))
        return f"{{ {first} {then} {goto} }}"

    def body(self) -> Iterator[str]:
        for _, lines in self.blocks:
            for line in lines:
                result = re.match(rf"({NAME}) = (.*)", line)
                if result:
                    self.declare(result[1], self.kind_of(result[2]))
        for label, lines in self.blocks:
            yield f"{self.labels[label]}:;"
            for line in lines:
                result = re.match(rf"({NAME}) = (.*)", line)
                if result:
                    text = self.expression(result[2])
                    if text is not None:
                        yield f"    {self.variables[result[1]][0]} = {text};"
                else:
                    statement = self.statement(label, line)
                    if statement:
                        yield f"    {statement}"

    def kind_of(self, text: str) -> str:
        """Return the type of an instruction's result."""
        opcode = text.split()[0]
        if opcode in ("icmp", "fcmp"):
            return "i1"
        if opcode in ("getelementptr", "alloca"):
            return "ptr"
        if " to " in text and opcode not in ("call", "tail", "phi"):
            return text.rsplit(" to ", 1)[1]
        if opcode in ("load",):
            return re.match(rf"load (?:atomic )?({TYPE}),", text)[1]  # type: ignore[index]
        if opcode == "select":
            return typed(split(text[len("select ") :])[1])[0]
        if opcode in ("shufflevector", "insertelement"):
            return "<8 x double>"
        if opcode in ("call", "tail"):
            return re.search(rf"({TYPE}) @", text)[1]  # type: ignore[index]
        return re.match(rf"\w+ {FLAGS}({TYPE})", text)[1]  # type: ignore[index]

    def expression(self, text: str) -> str | None:
        opcode, _, rest = text.partition(" ")
        rest = re.sub(rf"^{FLAGS}", "", rest)
        if opcode == "phi":
            return None
        if opcode in OPERATORS or opcode in SIGNED_OPERATORS:
            first, second = split(rest)
            kind, left = typed(first)
            a, b = self.value(kind, left), self.value(kind, second)
            if kind == "<8 x double>":
                return f"ov_{LANES[opcode]}({a}, {b})"
            if opcode in OPERATORS:
                whole = f"{a} {OPERATORS[opcode]} {b}"
                return f"({whole}) & 1" if kind == "i1" else whole
            signed = SIGNED[kind]
            return f"({C_TYPES[kind]})(({signed}){a} {SIGNED_OPERATORS[opcode]} ({signed}){b})"
        if opcode == "fneg":
            return f"-{self.value(*typed(rest))}"
        if opcode == "freeze":
            return self.value(*typed(rest))
        if opcode == "getelementptr":
            parts = split(rest)
            if len(parts) != 3:
                raise ValueError(f"an address with more than one index: {text}")
            return self.address(parts[0], self.value(*typed(parts[1])), *typed(parts[2]))
        if opcode == "load":
            atomic = rest.startswith("atomic ")
            kind, place = split(rest.removeprefix("atomic "))[:2]
            place = place.split(" acquire")[0]
            access = "acquire" if atomic else "load"
            return f"ov_{access}_{ACCESS[kind]}({self.value(*typed(place))})"
        if opcode in ("icmp", "fcmp"):
            first, second = split(rest)
            condition, operand = first.split(" ", 1)
            if opcode == "icmp" and operand.startswith("samesign"):
                operand = operand.removeprefix("samesign ")
            kind, left = typed(operand)
            return self.compare(condition, kind, self.value(kind, left), self.value(kind, second))
        if opcode == "select":
            condition, yes, no = (typed(part) for part in split(rest))
            return f"{self.value(*condition)} ? {self.value(*yes)} : {self.value(*no)}"
        if " to " in rest and opcode not in ("call", "tail"):
            return self.cast(opcode, rest)
        if opcode == "insertelement":
            # only as the first half of a splat
            return f"ov_splat({self.value(*typed(split(rest)[1]))})"
        if opcode == "shufflevector":
            vector, _, order = split(rest)
            if "zeroinitializer" not in order:
                raise ValueError(f"not a splat: {text}")
            return self.value(*typed(vector))
        if opcode in ("call", "tail"):
            return self.call(text)
        if opcode == "alloca":
            size = re.match(rf"alloca (?:\[(\d+) x ({TYPE})\]|({TYPE})|(\{{ ptr, i32 .*\}}))", text)
            if not size:
                raise ValueError(f"unknown room: {text}")
            self.rooms.append(
                16 if size[4] else int(size[1] or 1) * (SIZES[size[2] or size[3]] or 8)
            )
            return f"(unsigned char *)room{len(self.rooms) - 1}"
        raise ValueError(f"unknown instruction: {text}")

    def compare(self, condition: str, kind: str, a: str, b: str) -> str:
        if kind == "double":
            if condition == "ord":
                return f"({a} == {a}) & ({b} == {b})"
            if condition == "uno":
                return f"({a} != {a}) | ({b} != {b})"
            if condition == "one":
                return f"({a} < {b}) | ({a} > {b})"
            if condition == "ueq":
                return f"!(({a} < {b}) | ({a} > {b}))"
            if condition in UNORDERED:
                return f"!({a} {ORDERED[UNORDERED[condition]]} {b})"
            return f"{a} {ORDERED[condition]} {b}"
        if condition[0] == "s":
            signed = SIGNED[kind]
            return f"({signed}){a} {COMPARES[condition[1:]]} ({signed}){b}"
        return f"{a} {COMPARES[condition.lstrip('u')]} {b}"

    def cast(self, opcode: str, rest: str) -> str:
        operand, to = rest.rsplit(" to ", 1)
        kind, text = typed(operand)
        x = self.value(kind, text)
        if opcode == "bitcast" and {kind, to} == {"i64", "double"}:
            return f"ov_bits({x})" if to == "i64" else f"ov_double({x})"
        if opcode in ("zext", "uitofp", "fptrunc", "fpext"):
            return f"({C_TYPES[to]}){x}"
        if opcode == "trunc":
            return f"({C_TYPES[to]})({x}{' & 1' if to == 'i1' else ''})"
        if opcode == "sext":
            if kind == "i1":
                return f"({C_TYPES[to]})-(int64_t){x}"
            return f"({C_TYPES[to]})({SIGNED[to]})({SIGNED[kind]}){x}"
        if opcode == "sitofp":
            return f"({C_TYPES[to]})({SIGNED[kind]}){x}"
        if opcode == "fptosi":
            return f"({C_TYPES[to]})({SIGNED[to]}){x}"
        raise ValueError(f"unknown cast: {opcode} {rest}")

    def call(self, text: str) -> str:
        found = re.search(r"@([\w.]+)\((.*)\)$", text)
        if not found:
            raise ValueError(f"unknown call: {text}")
        arguments = ", ".join(self.value(*typed(part)) for part in split(found[2]))
        return f"{CALLS.get(found[1]) or self.names[found[1]]}({arguments})"

    def statement(self, label: str, line: str) -> str:
        opcode = line.split()[0]
        if opcode == "store":
            atomic = " atomic " in line[:14]
            value, place = split(line.replace("store atomic", "store", 1)[6:])[:2]
            kind, text = typed(value)
            place = place.split(" release")[0]
            to, x = self.value(*typed(place)), self.value(kind, text)
            access = "release" if atomic else "store"
            return f"ov_{access}_{ACCESS[kind]}({to}, {x});"
        if opcode == "br":
            targets = [bare(name) for name in re.findall(f"label ({NAME})", line)]
            if len(targets) == 1:
                return self.jump(label, targets[0])
            condition = self.value(*typed(split(line[3:])[0]))
            yes, no = (self.jump(label, target) for target in targets)
            return f"if ({condition}) {yes} else {no}"
        if opcode == "switch":
            head, cases = line[7:].split("[", 1)
            kind, text = typed(split(head)[0])
            pattern = rf"{kind} (-?\d+), label ({NAME})"
            default = re.search(f"label ({NAME})", head)
            chosen = " ".join(
                f"case {self.value(kind, number)}: {self.jump(label, bare(target))}"
                for number, target in re.findall(pattern, cases)
            )
            assert default
            otherwise = self.jump(label, bare(default[1]))
            return f"switch ({self.value(kind, text)}) {{ {chosen} default: {otherwise} }}"
        if opcode == "ret":
            return "return;" if line == "ret void" else f"return {self.value(*typed(line[4:]))};"
        if opcode == "unreachable":
            return ""
        if opcode in ("call", "tail"):
            if any(f"@{skipped}" in line for skipped in SKIPPED):
                return ""
            if "@llvm.memset" in line:
                to, byte, size, _ = (typed(part) for part in split(line[line.index("(") + 1 : -1]))
                return (
                    f"memset({self.value(*to)}, {self.value(*byte)}, (size_t){self.value(*size)});"
                )
            return f"{self.call(line)};"
        raise ValueError(f"unknown instruction: {line}")

    # --- the whole -------------------------------------------------------------------------------

    def head(self, name: str) -> str:
        kinds = dict(self.variables.values())
        given = ", ".join(f"{C_TYPES[kinds[p]]} {p}" for p in self.parameters)
        return f"static {C_TYPES[self.result]} {name}({given or 'void'})"

    def written(self, name: str) -> str:
        """Return the function as C."""
        statements = list(self.body())
        by_kind: dict[str, list[str]] = {}
        for variable, kind in self.variables.values():
            if variable not in self.parameters:
                by_kind.setdefault(C_TYPES[kind], []).append(variable)
        lines = [f"{self.head(name)} {{"]
        for kind, variables in by_kind.items():
            star = "*" if kind.endswith("*") else ""
            base = kind.rstrip(" *")
            for i in range(0, len(variables), 12):
                row = ", ".join(f"{star}{variable}" for variable in variables[i : i + 12])
                lines.append(f"    {base} {row};")
        lines += [f"    uint64_t room{i}[{-(-size // 8)}];" for i, size in enumerate(self.rooms)]
        return "\n".join([*lines, *statements, "}"]) + "\n"


def literal(text: str) -> str:
    """Return an exact floating-point constant."""
    number = struct.unpack(">d", bytes.fromhex(text[2:].zfill(16)))[0] if text[:2] == "0x" else None
    return f"({(float(text) if number is None else number).hex()})"


def constants(text: str) -> dict[str, bytes]:
    """Return the module's constant bytes by name."""
    found = {}
    pattern = r'^@([\w.$-]+) = [\w ]*constant \[\d+ x i8\] c"(.*?)"'
    for name, written in re.findall(pattern, text, re.M):
        parts = re.findall(r"\\([0-9A-F]{2})|(.)", written)
        found[name] = bytes(int(code, 16) if code else ord(letter) for code, letter in parts)
    return found


def translated(text: str, entries: dict[str, str]) -> str:
    """Return a module as C with static functions; `entries` renames some of them."""
    bytes_of = constants(text)
    names = {name: f"ov_constant{i}" for i, name in enumerate(bytes_of)}
    texts = re.findall(r"^define .*?^\}$", text, re.M | re.S)
    for i, function in enumerate(texts):
        name = function[function.index("@") + 1 : function.index("(", function.index("@"))]
        names[name] = entries.get(name, f"ov_function{i}")
    functions = [Function(text, names) for text in texts]
    parts = [HEAD]
    for name, content in bytes_of.items():
        row = ", ".join(str(byte) for byte in content)
        parts.append(f"static const unsigned char {names[name]}[{len(content)}] = {{{row}}};\n")
    parts += [f"{function.head(names[function.name])};\n" for function in functions]
    parts += [function.written(names[function.name]) for function in functions]
    return "\n".join(parts)
