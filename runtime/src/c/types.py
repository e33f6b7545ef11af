#!/usr/bin/env python3
"""The types of the library for C, from the public headers of C++, which describe them: structs, enumerations, constants.

    types.py           writes runtime/include/fjell/fjell_c_types.h and runtime/src/c/types.inc
    types.py --check   says what differs from them, and fails if anything does

A field of C++ becomes a field of C: std::span two of them, a type of the library the type of C of that name. What C
names or needs otherwise stands in the tables below. Headers are read as they are formatted: a declaration at the
beginning of a line.
"""
import difflib
import pathlib
import re
import sys
import textwrap

SOURCE = pathlib.Path(__file__).resolve().parent
INCLUDE = SOURCE.parent.parent / "include" / "fjell"
HEADERS = ("status asserts handle sample_index pack pack_set texture terrain pages view mesh jobs cut compact recursive measure query"
           " stream edit ground_maps").split()

# Descriptors and reports: they may grow, so they begin with struct_size.
SIZED = {"TerrainBudget", "View", "CutBudget", "CutSettings", "CutReport", "RecursiveBudget", "RefineSettings",
         "FrameReport", "StreamBudget", "StreamSettings", "StreamReport", "EditBudget", "Stamp", "EditSettings", "EditReport",
         "GroundMapsBudget", "GroundMapsReport"}
LAST = {"MeshView": "topology"}  # a field that C has behind the others
COPIED_BY_HAND = {"MeshView", "CutMesh"}  # c/mesh.cpp
LEFT_OUT = {"PageHead", "PageFlags"}
PREFIX = {"StatusCode": "", "ChunkKind": "CHUNK_", "MapKind": "MAP_", "PageEvent": "PAGE_"}  # of enumerators; else the type's
COUNT = {"bytes": "byte_count", "vertex_bits": "vertex_bit_words", "triangle_bits": "triangle_bit_words",
         "vertices": "vertex_count", "indices": "index_count", "morph": "morph_count"}  # of the second field of a span
AFTER = {"cut": """
// Slots that were written, one after the other. Begin with {0}.
typedef struct FjellRun {
    uint32_t first, count;
    size_t words_begun; // the library's, and so is what follows
    uint64_t bits_left;
} FjellRun;
"""}

HEAD = """\
// The types of fjell/fjell_c.h. Fields are those of the C++ types of the same name, whose headers give units and
// ranges. runtime/src/c/types.py writes this file from those headers: change them, then run it. The library checks at
// compile time that both layouts are equal.
#ifndef FJELL_FJELL_C_TYPES_H
#define FJELL_FJELL_C_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fjell/export.h"
"""


class Header:
    """What stands in one header, as lines of C, and the macro calls that compare it with C++."""

    def __init__(self, constants, types):
        self.constants, self.types = constants, types  # names seen so far, in all headers
        self.c, self.compared = [], []

    def type_of(self, cpp):
        cpp = cpp.replace("std::", "").strip()
        const, name = ("const ", cpp[6:]) if cpp.startswith("const ") else ("", cpp)
        pointer = "*" if name.endswith("*") else ""
        name = name.rstrip("*")
        name = "void" if name == "byte" else name
        return const + ("Fjell" + name if name in self.types else name) + pointer

    def constant(self, declaration):
        """inline constexpr TYPE NAME = VALUE, NAME = VALUE"""
        kind, rest = re.match(r"((?:std::)?\w+) (.*)", declaration, re.S).groups()
        for name, value in re.findall(r"(\w+) = ([^,]+)(?:,|$)", rest):
            value = re.sub(r"std::uint64_t\{(\w+)\}", r"\1ull", value.replace("'", "")).strip()
            value = re.sub(r"[A-Za-z_]\w*", lambda m: self.constants.get(m[0], m[0]), value)
            if kind in ("float", "double") and re.fullmatch(r"\d+", value):
                value += ".0"
            if kind == "float" and not value.endswith("f"):
                value += "f"
            self.constants[name] = "FJELL_" + name.upper()
            self.c.append(f"#define FJELL_{name.upper()} " + (value if re.fullmatch(r"\w[\w.-]*", value) else f"({value})"))

    def enumeration(self, scoped, name, underlying, body):
        prefix = PREFIX.get(name, re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).upper() + "_") if scoped else ""
        values = [f"FJELL_{prefix}{v.strip().upper()}" for v in re.sub(r"\s+", " ", body).split(",")]
        values = [v.replace("U <<", "u <<") for v in values]
        self.types.add(name)
        line = "enum { " + ", ".join(values) + " };"
        self.c += ["", f"typedef {underlying.replace('std::', '')} Fjell{name};"]
        self.c += [line] if len(line) <= 120 else ["enum {", *("    " + v + "," for v in values[:-1]),
                                                   "    " + values[-1], "};", ""]

    def structure(self, name, body):
        while "{" in body:  # bodies of functions, and initial values
            body = re.sub(r"\)( const)? \{[^{}]*\}", ");", body) if re.search(r"\)( const)? \{[^{}]*\}", body) else \
                re.sub(r"(\s*=)?\s*\{[^{}]*\}", "", body)
        fields = []  # lines of C, and the names of what they declare
        for declaration in (re.sub(r"\s+", " ", d).strip() for d in body.split(";")):
            if pointer := re.search(r"\(\*(\w+)\)", declaration):  # to a function
                fields.append((declaration.split(" = ")[0].replace("std::", "") + ";", [pointer[1]]))
            elif declaration and "(" not in declaration:
                kind, rest = re.match(r"((?:const )?[\w:]+(?:<[^>]*>)?\*?) (.*)", declaration).groups()
                names = [re.match(r"\w+(\[[^\]]*\])?", n.strip())[0] for n in rest.split(",")]
                if span := re.match(r"std::span<(.*)>", kind):
                    for n in names:
                        count = COUNT.get(n) or n.rstrip("s") + ("_bytes" if "byte" in kind else "_count")
                        fields += [(f"{self.type_of(span[1])}* {n};", [n]), (f"size_t {count};", [])]
                else:
                    names = [re.sub(r"[a-z]\w*(?=[^\[]*\])", lambda m: self.constants.get(m[0], m[0]), n) for n in names]
                    line = f"{self.type_of(kind)} {', '.join(names)};"
                    fields.append((line, [n.split("[")[0] for n in names]))
        fields.sort(key=lambda f: LAST.get(name) in f[1])
        self.types.add(name)
        sized = ["    uint64_t struct_size;"] if name in SIZED else []
        self.c += ["", f"typedef struct Fjell{name} {{", *sized, *("    " + f for f, _ in fields), f"}} Fjell{name};", ""]
        if name not in COPIED_BY_HAND:
            self.compared.append((name, [n for _, names in fields for n in names]))

    def handle(self, name):
        self.types.add(name)
        self.c += ["", f"typedef struct Fjell{name} {{", "    void* object;", "    uint64_t identity;",
                   f"}} Fjell{name};", ""]
        self.compared.append((name, []))

    def read(self, text):
        text = re.sub(r"\s*//.*", "", text)
        for found in re.finditer(
                r"^inline constexpr (?P<constant>[^;\[]*);"
                r"|^enum (?P<scoped>class )?(?P<enum>\w+) : (?P<underlying>[\w:]+) \{(?P<values>[^}]*)\};"
                r"|^struct (?:\[\[nodiscard\]\] )?(?P<struct>\w+) \{(?P<body>.*?)^\};"
                r"|^using (?P<function>\w+) = void \(\*\)(?P<parameters>\([^;]*\));"
                r"|^(?:using|class) (?P<handle>\w+) (?:=|: public) Handle<\w+>", text, re.M | re.S):
            if found["constant"]:
                self.constant(found["constant"])
            elif found["enum"] and found["enum"] not in LEFT_OUT:
                self.enumeration(found["scoped"], found["enum"], found["underlying"], found["values"])
            elif found["struct"] and found["struct"] not in LEFT_OUT:
                self.structure(found["struct"], found["body"])
            elif found["function"]:
                self.c += ["", f"typedef void (*Fjell{found['function']}){found['parameters']};"]
            elif found["handle"]:
                self.handle(found["handle"])


def generate():
    constants, types, compared, c = {}, set(), [], HEAD
    for name in HEADERS:
        header = Header(constants, types)
        header.read((INCLUDE / f"{name}.h").read_text())
        if header.c:
            c += f"\n// --- fjell/{name}.h ---\n\n" + re.sub(r"\n\n+", "\n\n", "\n".join(header.c).strip("\n")) + "\n"
        c += AFTER.get(name, "")
        compared += header.compared
    c += "\n#endif\n"
    inc = "// Written by types.py: a type of both languages, and its fields that lie alike.\n"
    for name, fields in compared:
        line = f"FJELL_C_TYPE({name},{''.join(f' FJELL_AT({f})' for f in fields)})"
        inc += "\n".join(textwrap.wrap(line, 120, subsequent_indent="    ")) + "\n"
    return {INCLUDE / "fjell_c_types.h": c, SOURCE / "types.inc": inc}


def main(arguments):
    differences = []
    for path, text in generate().items():
        if arguments == ["--check"]:
            differences += difflib.unified_diff(path.read_text().splitlines(), text.splitlines(), str(path), "types.py",
                                                lineterm="")
        else:
            path.write_text(text)
    if differences:
        print("\n".join(differences))
        sys.exit("the C++ headers say otherwise: run runtime/src/c/types.py")


main(sys.argv[1:])
