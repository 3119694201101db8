"""The planner's archive as the linker sees it: what it needs from outside, and that it holds no state."""
import os
import pathlib
import re
import tempfile
import unittest

from core import ROOT, run

ARCHIVE = os.environ["SSV_PLANNER_ARCHIVE"]
SCALAR = os.environ["SSV_REAL"]
# What the archive may keep between calls: the fixed scalar's count of overflows.
STATE = {"double": [], "float": [], "fixed": ["overflows"]}
# What a compiler calls by itself: memory functions, one call for a sine and a cosine of the same angle, asserts, hardening.
OTHERS = {"memcpy", "memset", "memmove", "memcmp", "sincos", "__assert_fail", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}


def libm_of(scalar):
    """The libm functions that a scalar's header passes on: calls in it to names that do not begin with real_."""
    text = (ROOT / f"firmware/include/ssv/real_{scalar}.h").read_text()
    return set(re.findall(r"(?:return|[=:])\s+((?!real_|is)[a-z]\w*)\(", text))


def breaches(archive):
    """Undefined symbols that are not on the list, and variables that can be written (.data.rel.ro cannot, once loaded)."""
    defined, undefined, writable = set(), set(), set()
    for line in run(["objdump", "--syms", archive]).splitlines():
        match = re.match(r"[0-9a-f]+ .{6}(.) (\S+)\s+[0-9a-f]+\s+(?:\.\w+ )?(\S+)$", line)
        if not match:
            continue
        kind, section, name = match.groups()
        (undefined if section == "*UND*" else defined).add(name)
        if kind == "O" and re.match(r"\*COM\*|\.t?(?:data(?!\.rel\.ro)|bss)", section):
            writable.add(name)
    return {"undefined": sorted(undefined - defined - OTHERS - libm_of(SCALAR)), "writable": sorted(writable)}


class Symbols(unittest.TestCase):
    def archive_of(self, source):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        folder = pathlib.Path(scratch.name)
        (folder / "a.c").write_text(source)
        run([os.environ["CC"], "-O2", "-c", "a.c", "-o", "a.o"], cwd=folder)
        run(["ar", "rcs", "a.a", "a.o"], cwd=folder)
        return folder / "a.a"

    def test_archive_needs_the_libm_of_its_scalar_and_memory_functions_alone_and_holds_no_state(self):
        self.assertIn("sqrt", libm_of("double"))
        self.assertIn("sqrtf", libm_of("float"))
        self.assertEqual(libm_of("fixed"), set())
        self.assertEqual(breaches(ARCHIVE), {"undefined": [], "writable": STATE[SCALAR]})

    def test_heap_stdio_other_libm_and_state_are_found(self):
        planted = {
            "#include <stdlib.h>\nvoid* f(void) { return malloc(3); }": ("undefined", "malloc"),
            "#include <stdio.h>\nint f(int x) { return printf(\"%d\", x); }": ("undefined", "printf"),
            "#include <math.h>\ndouble f(double x) { return pow(x, 0.3); }": ("undefined", "pow"),
            "void* lcm_create(const char*);\nvoid* f(void) { return lcm_create(0); }": ("undefined", "lcm_create"),
            "int f(void) { static int count; return count++; }": ("writable", "count"),
            "int seed = 4;": ("writable", "seed"),
            "const char* words[] = {\"a\"};": ("writable", "words"),
        }
        for source, (kind, name) in planted.items():
            with self.subTest(source=source):
                self.assertIn(name, " ".join(breaches(self.archive_of(source))[kind]))


if __name__ == "__main__":
    unittest.main()
