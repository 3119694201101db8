"""The planner core's call graph: no function reaches itself, so the stack has a bound."""
import os
import pathlib
import re
import tempfile
import unittest

from core import CORE, core_flags, in_a_cycle, run


def call_graph(sources):
    """{caller: {callee}} of gcc without inlining; a function is "FILE:name" when static, else "name"."""
    edges = {}
    with tempfile.TemporaryDirectory() as scratch:
        for number, source in enumerate(sources):
            run(["gcc", *core_flags(), "-O0", "-fcallgraph-info", "-c", source, "-o", f"{scratch}/{number}.o"])
        for graph in pathlib.Path(scratch).glob("*.ci"):
            for caller, callee in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', graph.read_text()):
                edges.setdefault(caller, set()).add(callee)
    return edges


def loops(edges):
    """Functions that can come to call themselves. A call through a pointer may reach anything, so it counts as one."""
    return sorted({*in_a_cycle(edges), *(caller for caller in edges if "__indirect_call" in edges[caller])})


class Recursion(unittest.TestCase):
    def test_no_function_of_the_core_can_come_to_call_itself(self):
        edges = call_graph(sorted(CORE.glob("**/*.c")))
        self.assertIn(f"ssv_plan_{os.environ['SSV_REAL']}", edges)
        self.assertEqual(loops(edges), [])

    def test_planted_loops_are_found(self):
        planted = {
            "int f(int n) { return n ? f(n - 1) : 0; }": "f",
            "static int g(int n);\nint f(int n) { return g(n); }\nstatic int g(int n) { return n ? f(n - 1) : 0; }": "f",
            "int f(int (*call)(int)) { return call(1); }": "f",
        }
        for source, name in planted.items():
            with self.subTest(source=source), tempfile.TemporaryDirectory() as scratch:
                file = pathlib.Path(scratch) / "planted.c"
                file.write_text(source)
                self.assertIn(name, loops(call_graph([file])))

    def test_a_loop_over_two_files_is_found(self):
        with tempfile.TemporaryDirectory() as scratch:
            one, two = pathlib.Path(scratch) / "one.c", pathlib.Path(scratch) / "two.c"
            one.write_text("int g(int n);\nint f(int n) { return n ? g(n) : 0; }")
            two.write_text("int f(int n);\nint g(int n) { return f(n - 1); }")
            self.assertEqual(loops(call_graph([one, two])), ["f", "g"])


if __name__ == "__main__":
    unittest.main()
